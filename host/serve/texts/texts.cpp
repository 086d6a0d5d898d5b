#include "host/serve/texts/texts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <map>
#include <nlohmann/json.hpp>
#include <ranges>

#include "host/serve/texts/catalogs.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr std::string_view english = "en";

using Translations = std::map<std::string, std::string, std::less<>>;

/// The translations of all languages but English.
const std::map<std::string, Translations, std::less<>>& all_translations() {
    static const auto read = [] {
        std::map<std::string, Translations, std::less<>> result;
        for (const Catalog& each : catalogs) {
            result.emplace(each.language, nlohmann::json::parse(each.json).get<Translations>());
        }
        return result;
    }();
    return read;
}

/// The translation of a text; null if the language has none.
const std::string* translation(std::string_view text, std::string_view language) {
    const auto catalog = all_translations().find(language);
    if (catalog == all_translations().end()) {
        return nullptr;
    }
    const auto found = catalog->second.find(text);
    return found == catalog->second.end() ? nullptr : &found->second;
}

/// "de" of " DE-at ".
std::string primary_tag(std::string_view text) {
    constexpr std::string_view blanks = " \t";
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    text = text.substr(0, text.find_first_of("-; \t"));
    std::string tag(text);
    std::ranges::transform(tag, tag.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return tag;
}

bool is_language(std::string_view language) {
    return language == english || all_translations().contains(language);
}

/// The weight of an entry such as "de-AT;q=0.8"; 1 if it names none.
double weight_of(std::string_view entry) {
    constexpr std::string_view name = "q=";
    const std::size_t at = entry.find(name);
    if (at == std::string_view::npos) {
        return 1;
    }
    double weight = 0;
    const std::string_view digits = entry.substr(at + name.size());
    std::from_chars(digits.data(), digits.data() + digits.size(), weight);
    return weight;
}

}  // namespace

std::string language_of(std::string_view asked, std::string_view accept_language) {
    if (const std::string tag = primary_tag(asked); is_language(tag)) {
        return tag;
    }
    std::string best(english);
    double most = 0;
    for (const auto part : std::views::split(accept_language, ',')) {
        const std::string_view entry(part.begin(), part.end());
        const std::string tag = primary_tag(entry);
        if (const double weight = weight_of(entry); weight > most && is_language(tag)) {
            best = tag;
            most = weight;
        }
    }
    return best;
}

bool has_text(std::string_view text, std::string_view language) {
    return language == english || translation(text, language) != nullptr;
}

std::size_t count_of_texts(std::string_view language) {
    const auto catalog = all_translations().find(language);
    return catalog == all_translations().end() ? 0 : catalog->second.size();
}

std::string text_in(const Text& text, std::string_view language) {
    const std::string* found = translation(text.english, language);
    std::string result = found == nullptr ? std::string(text.english) : *found;
    for (std::size_t n = 0; n < text.parts.size(); ++n) {
        const std::string place = fmt::format("{{{}}}", n);
        if (const std::size_t at = result.find(place); at != std::string::npos) {
            result.replace(at, place.size(), text.parts[n]);
        }
    }
    return result;
}

}  // namespace pxpl5::host::serve

// Whether a text is XML, as far as the program writes it.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::test {

/// The first error in `text`, the attributes of a tag `name`.
inline std::string attribute_fault(const std::string& name, std::string_view text) {
    std::vector<std::string> names;
    for (std::size_t at = 0; at < text.size();) {
        while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at])) != 0) {
            ++at;
        }
        if (at == text.size()) {
            break;
        }
        const std::size_t equals = text.find("=\"", at);
        if (equals == std::string_view::npos) {
            return "an attribute without quotes in <" + name + ">";
        }
        const std::string attribute(text.substr(at, equals - at));
        if (std::ranges::find(names, attribute) != names.end()) {
            return attribute + " twice in <" + name + ">";
        }
        names.push_back(attribute);
        at = text.find('"', equals + 2);
        if (at == std::string_view::npos) {
            return "an attribute without end in <" + name + ">";
        }
        ++at;
    }
    return "";
}

/// The document's first error; empty if it has none: every tag closed in its turn, one root,
/// every attribute quoted and given once, no bare & or <.
inline std::string xml_fault(std::string_view text) {
    std::vector<std::string> open;
    int roots = 0;
    for (std::size_t at = 0; at < text.size(); ++at) {
        if (text[at] == '&') {
            const std::size_t end = text.find(';', at);
            const std::string_view name = text.substr(at + 1, end - at - 1);
            if (name != "amp" && name != "lt" && name != "gt" && name != "quot" && name != "apos") {
                return "bare & at " + std::to_string(at);
            }
        }
        if (text[at] != '<') {
            continue;
        }
        const std::size_t end = text.find('>', at);
        if (end == std::string_view::npos) {
            return "a tag without end";
        }
        std::string_view tag = text.substr(at + 1, end - at - 1);
        at = end;
        if (tag.find('<') != std::string_view::npos) {
            return "bare < in " + std::string(tag);
        }
        if (tag.starts_with("?")) {
            continue;
        }
        if (tag.starts_with("/")) {
            if (open.empty() || open.back() != tag.substr(1)) {
                return "unexpected </" + std::string(tag.substr(1)) + ">";
            }
            open.pop_back();
            continue;
        }
        const bool is_closed = tag.ends_with("/");
        tag.remove_suffix(is_closed ? 1 : 0);
        std::size_t name_end = tag.find_first_of(" \n");
        name_end = name_end == std::string_view::npos ? tag.size() : name_end;
        const std::string name(tag.substr(0, name_end));
        if (const std::string fault = attribute_fault(name, tag.substr(name_end)); !fault.empty()) {
            return fault;
        }
        if (open.empty()) {
            ++roots;
        }
        if (!is_closed) {
            open.push_back(name);
        }
    }
    return !open.empty() ? "<" + open.back() + "> is not closed" : roots == 1 ? "" : "not one root";
}

}  // namespace pxpl5::test

#include "host/phantom/phantom.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "host/phantom/catalogue.hpp"

namespace pxpl5::host {

namespace {

constexpr std::string_view prefix = "phantom:";

struct Entry {
    PhantomInfo (*info)();
    Volume (*make)(const PhantomInfo& info);
};

constexpr Entry catalogue[] = {
    {phantom::pelvis_info, phantom::make_pelvis}, {phantom::fetus_info, phantom::make_fetus},
    {phantom::head_info, phantom::make_head},     {phantom::sphere_info, phantom::make_sphere},
    {phantom::torus_info, phantom::make_torus},   {phantom::letters_info, phantom::make_letters},
};

/// Levenshtein's distance: letters to insert, remove or replace.
std::size_t edits_between(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i + 1;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

[[noreturn]] void throw_unknown(std::string_view name) {
    std::string known, nearest;
    std::size_t least = std::string::npos;
    for (const PhantomInfo& info : phantoms()) {
        known += (known.empty() ? "" : ", ") + info.name;
        const std::size_t edits = edits_between(name, info.name);
        if (edits < least) {
            least = edits;
            nearest = info.name;
        }
    }
    throw std::invalid_argument("no phantom \"" + std::string(name) + "\"; did you mean " +
                                nearest + "? Known: " + known);
}

}  // namespace

std::vector<PhantomInfo> phantoms() {
    std::vector<PhantomInfo> infos;
    for (const Entry& entry : catalogue) infos.push_back(entry.info());
    return infos;
}

bool is_phantom(std::string_view name) {
    return name.starts_with(prefix);
}

Volume make_phantom(std::string_view name) {
    for (const Entry& entry : catalogue) {
        const PhantomInfo info = entry.info();
        if (info.name == name) return entry.make(info);
    }
    throw_unknown(name);
}

}  // namespace pxpl5::host

#include "host/phantom/phantom.hpp"

#include <stdexcept>

#include "host/base/nearest.hpp"
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

[[noreturn]] void throw_unknown(std::string_view name) {
    const std::vector<PhantomInfo> infos = phantoms();
    std::vector<std::string_view> names;
    std::string known;
    for (const PhantomInfo& info : infos) {
        known += (known.empty() ? "" : ", ") + info.name;
        names.push_back(info.name);
    }
    throw std::invalid_argument("no phantom \"" + std::string(name) + "\"; did you mean " +
                                std::string(nearest(name, names)) + "? Known: " + known);
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

std::vector<PhantomSurface> suggested_surfaces(std::string_view volume_name) {
    for (const PhantomInfo& info : phantoms()) {
        if (info.name == volume_name) return info.surfaces;
    }
    return {};
}

Volume make_phantom(std::string_view name) {
    for (const Entry& entry : catalogue) {
        const PhantomInfo info = entry.info();
        if (info.name == name) return entry.make(info);
    }
    throw_unknown(name);
}

}  // namespace pxpl5::host

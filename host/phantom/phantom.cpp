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
    Volume (*make_frame)(const PhantomInfo& info, int frame) = nullptr;  ///< For a time series.
};

constexpr Entry catalogue[] = {
    {phantom::pelvis_info, phantom::make_pelvis},
    {phantom::fetus_info, phantom::make_fetus},
    {phantom::head_info, phantom::make_head},
    {phantom::sphere_info, phantom::make_sphere},
    {phantom::torus_info, phantom::make_torus},
    {phantom::letters_info, phantom::make_letters},
    {phantom::heart_info, nullptr, phantom::make_heart},
    {phantom::waving_fetus_info, nullptr, phantom::make_waving_fetus},
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

[[noreturn]] void throw_no_frame(const PhantomInfo& info, int frame) {
    const std::string frames = std::to_string(info.frames);
    throw std::invalid_argument(
        info.name + ": frame is " + std::to_string(frame) + ", but the phantom has " +
        (info.frames == 1 ? "one volume: load it without frame="
                          : frames + " volumes: give frame=1 to " + frames));
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

Volume make_phantom(std::string_view name, int frame) {
    for (const Entry& entry : catalogue) {
        const PhantomInfo info = entry.info();
        if (info.name != name) continue;
        if (frame < 1 || frame > info.frames) throw_no_frame(info, frame);
        return entry.make_frame != nullptr ? entry.make_frame(info, frame) : entry.make(info);
    }
    throw_unknown(name);
}

}  // namespace pxpl5::host

// Commands about lights and what they meet.
#include <fmt/format.h>

#include <string_view>
#include <utility>
#include <vector>

#include "host/commands/command_handlers.hpp"
#include "ringbus/rules/light_sum.hpp"

namespace pxpl5::host {

namespace {

/// The arrangement of lights of that name; empty if there is none.
std::vector<Light> arrangement(std::string_view name) {
    if (name == "two-point") {
        return Scene{}.lights;
    }
    if (name == "three-point") {  // Key, fill, and a light from behind that shows the edges.
        return {{-38, 42, 0.66}, {50, -5, 0.22}, {150, 35, 0.6}};
    }
    return {};
}

Reply describe_lights(const std::vector<Light>& lights) {
    Reply reply;
    std::vector<Fields> list;
    for (const Light& light : lights) {
        list.push_back({{"azimuth_deg", light.azimuth_deg},
                        {"elevation_deg", light.elevation_deg},
                        {"intensity", light.intensity}});
        reply.text +=
            fmt::format("{}light {} {} {} intensity={}", reply.text.empty() ? "" : "\n",
                        list.size(), light.azimuth_deg, light.elevation_deg, light.intensity);
    }
    if (list.empty()) {
        reply.text = "no light is on";
    }
    reply.fields = {{"lights", static_cast<std::int64_t>(lights.size())}, {"list", list}};
    return reply;
}

/// Throws if the Renderers cannot add up so much light.
void check_light(const Material& material, const std::vector<Light>& lights) {
    double sum = static_cast<float>(material.ambient);  // As in a frame's request.
    for (const Light& light : lights) {
        sum += static_cast<float>(light.intensity);
    }
    if (sum > bus::max_light_sum) {
        refuse_command(
            fmt::format("the ambient light of {} and all intensities add up to {:.3g}, "
                        "{} are the most; choose lower ones",
                        material.ambient, sum, bus::max_light_sum));
    }
}

}  // namespace

Reply run_light(Session& session, const Arguments& arguments) {
    auto& lights = session.scene.lights;
    if (arguments.words.empty()) {
        return describe_lights(lights);
    }
    if (arguments.words[0] == "off") {
        lights.clear();
        return describe_lights(lights);
    }
    if (const std::vector<Light> wanted = arrangement(arguments.words[0]); !wanted.empty()) {
        if (arguments.words.size() > 1 || arguments.has("intensity")) {
            refuse_command(fmt::format("light {}: takes no further words", arguments.words[0]));
        }
        check_light(session.scene.material, wanted);
        lights = wanted;
        return describe_lights(lights);
    }
    const auto index =
        static_cast<std::size_t>(parse_whole("N", arguments.words[0], 1, max_lights)) - 1;
    if (index > lights.size()) {
        refuse_command(fmt::format("light {}: {} lights are on, so the next light is {}",
                                   arguments.words[0], lights.size(), lights.size() + 1));
    }
    if (arguments.words.back() == "off") {
        if (index < lights.size()) {
            lights.erase(lights.begin() + static_cast<std::ptrdiff_t>(index));
        }
    } else if (arguments.words.size() == 3) {
        const double before = index < lights.size() ? lights[index].intensity : 0.8;
        const Light light{
            parse_number("azimuth", arguments.words[1], -max_angle_deg, max_angle_deg),
            parse_number("elevation", arguments.words[2], -90, 90),
            arguments.number("intensity", before)};
        std::vector<Light> wanted = lights;
        index < wanted.size() ? wanted[index] = light : wanted.emplace_back(light);
        check_light(session.scene.material, wanted);
        lights = std::move(wanted);
    } else {
        refuse_command(
            fmt::format("light {0}: give azimuth and elevation, or off; for example "
                        "light {0} 30 20",
                        arguments.words[0]));
    }
    return {fmt::format("{} of {} lights on", lights.size(), max_lights),
            {{"lights", static_cast<std::int64_t>(lights.size())}}};
}

Reply run_material(Session& session, const Arguments& arguments) {
    Material material = session.scene.material;
    material.ambient = arguments.number("ambient", material.ambient);
    material.specular = arguments.number("specular", material.specular);
    const double power = arguments.number("power", material.specular_power);
    material.specular_power = static_cast<std::uint32_t>(power);
    check_light(material, session.scene.lights);
    session.scene.material = material;
    return {fmt::format("ambient {} specular {} power {}", material.ambient, material.specular,
                        material.specular_power),
            {{"ambient", material.ambient},
             {"specular", material.specular},
             {"power", static_cast<std::int64_t>(material.specular_power)}}};
}

}  // namespace pxpl5::host

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <map>
#include <set>
#include <tuple>
#include <unordered_map>

#include "host/base/error.hpp"
#include "host/phigs/colors.hpp"
#include "host/phigs/content.hpp"

namespace pxpl5::host::phigs {

namespace {

/// A sphere's matrix may scale its axes so differently, relatively.
constexpr double sphere_tolerance = 1e-6;
constexpr double max_coordinate = 1e15;

/// State that executed structures inherit.
struct State {
    glm::dmat4 matrix{1.0};
    struct Look {
        Color front{230, 230, 230}, back{230, 230, 230};
        Specular specular;
        bool has_specular = false;
    };
    std::array<Look, kind_names.size()> looks;
};

bool same(Color a, Color b) {
    return a.r == b.r && a.g == b.g && a.b == b.b;
}

class Flattener {
  public:
    explicit Flattener(const Archive& archive) : archive_(archive) {
        content_.file = archive.file;
        content_.structures = archive.structures.size();
        for (std::size_t i = 0; i < archive.structures.size(); ++i) {
            by_name_.emplace(archive.structures[i].name, i);
        }
    }

    Content run() {
        for (std::size_t i = 0; i < archive_.structures.size(); ++i) {
            if (archive_.structures[i].posted) {
                ++content_.posted;
                execute(i, State{}, 1);
            }
        }
        finish();
        return std::move(content_);
    }

  private:
    [[noreturn]] void refuse_at(Place at, const std::string& text) const {
        refuse_text(archive_.file, at, text);
    }

    void execute(std::size_t index, State state, std::size_t depth) {
        const Structure& structure = archive_.structures[index];
        active_.insert(index);
        for (const Element& element : structure.elements) {
            if (++visits_ > max_visits) {
                refuse_at(structure.at, fmt::format("more than {} elements are executed, here in "
                                                    "structure {}",
                                                    max_visits, structure.name));
            }
            if (const auto* e = std::get_if<ExecuteElement>(&element)) {
                execute(target(*e, depth), state, depth + 1);
            } else {
                std::visit([&](const auto& other) { take(other, state, structure); }, element);
            }
        }
        active_.erase(index);
    }

    std::size_t target(const ExecuteElement& e, std::size_t depth) const {
        const auto found = by_name_.find(e.name);
        if (found == by_name_.end()) {
            refuse_at(e.at, fmt::format("there is no structure {} to execute", e.name));
        }
        if (active_.contains(found->second)) {
            refuse_at(e.at, fmt::format("structure {} executes itself", e.name));
        }
        if (depth == max_execute_depth) {
            refuse_at(e.at, fmt::format("structure {} would be executed {} deep, {} are the most",
                                        e.name, depth + 1, max_execute_depth));
        }
        return found->second;
    }

    void take(const ExecuteElement&, State&, const Structure&) {}

    void take(const MatrixElement& e, State& state, const Structure& structure) {
        state.matrix = state.matrix * e.matrix;
        for (int column = 0; column < 4; ++column) {
            const glm::dvec4 c = glm::abs(state.matrix[column]);
            if (!(std::max({c.x, c.y, c.z}) <= max_coordinate)) {
                refuse_at(structure.at, fmt::format("the matrices of structure {} reach beyond {}",
                                                    structure.name, max_coordinate));
            }
        }
    }

    void take(const ColorElement& e, State& state, const Structure&) {
        State::Look& look = state.looks[static_cast<std::size_t>(e.kind)];
        if (e.diffuse) {
            look.front = e.diffuse->front;
            look.back = e.diffuse->back;
        }
        if (e.specular) {
            look.specular = *e.specular;
            look.has_specular = true;
        }
    }

    void take(const PolygonElement& e, State& state, const Structure& structure) {
        ++content_.polygons;
        std::vector<glm::dvec3> corners;
        for (const Corner& corner : e.corners) {
            corners.push_back(placed(state, corner.p, structure));
        }
        std::vector<glm::dvec3> normals;
        const glm::dmat3 linear(state.matrix);
        const bool mirrored = glm::determinant(linear) < 0;
        glm::dvec3 face = newell_normal(corners);
        if (glm::length(face) == 0) {
            ++flat_polygons_;
            return;
        }
        if (mirrored) {
            face = -face;
        }
        for (const Corner& corner : e.corners) {
            normals.push_back(normal_of(e, corner, linear, glm::normalize(face)));
        }
        State::Look look = state.looks[0];
        if (const auto own = own_color(e)) {
            look.front = look.back = *own;
        }
        note_specular(look, e.corners.size() - 2);
        if (e.cull_back || same(look.front, look.back)) {
            add_polygon({look.front, e.cull_back}, corners, normals, mirrored, structure);
        } else {
            add_polygon({look.front, true}, corners, normals, mirrored, structure);
            add_polygon({look.back, true}, corners, normals, !mirrored, structure);
        }
    }

    /// The polygon's color, or the mean of its corners'.
    std::optional<Color> own_color(const PolygonElement& e) {
        glm::dvec3 sum(0);
        double count = 0;
        for (const Corner& corner : e.corners) {
            if (corner.diffuse) {
                sum += glm::dvec3(corner.diffuse->r, corner.diffuse->g, corner.diffuse->b);
                ++count;
            }
        }
        if (count == 0) {
            return e.diffuse;
        }
        ++averaged_;
        const auto byte = [count](double total) {
            return static_cast<std::uint8_t>(std::lround(total / count));
        };
        return Color{byte(sum.x), byte(sum.y), byte(sum.z)};
    }

    /// In the archive's space; the face's own where the corner has none that means anything.
    static glm::dvec3 normal_of(const PolygonElement& e, const Corner& corner,
                                const glm::dmat3& linear, const glm::dvec3& face) {
        if (!e.has_normals) {
            return face;
        }
        const glm::dvec3 n = glm::transpose(glm::inverse(linear)) * corner.normal;
        const double length = glm::length(n);
        return length > 0 && std::isfinite(length) ? n / length : face;
    }

    void add_polygon(const Material& material, const std::vector<glm::dvec3>& corners,
                     const std::vector<glm::dvec3>& normals, bool reversed,
                     const Structure& structure) {
        const glm::dvec3 newell = newell_normal(corners);
        const std::vector<std::uint32_t> triangles = triangulate(corners, newell);
        Part& part = part_for(material, triangles.size() / 3, structure);
        const auto first = static_cast<std::uint32_t>(part.vertices.size());
        for (std::size_t i = 0; i < corners.size(); ++i) {
            part.vertices.push_back({corners[i], normals[i]});
        }
        for (std::size_t i = 0; i + 2 < triangles.size(); i += 3) {
            part.indices.push_back(first + triangles[i]);
            part.indices.push_back(first + triangles[i + (reversed ? 2 : 1)]);
            part.indices.push_back(first + triangles[i + (reversed ? 1 : 2)]);
        }
        content_.triangles += triangles.size() / 3;
    }

    void take(const SphereElement& e, State& state, const Structure& structure) {
        const glm::dmat3 m(state.matrix);
        const glm::dmat3 gram = glm::transpose(m) * m;
        const double scale2 = (gram[0][0] + gram[1][1] + gram[2][2]) / 3;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                if (!(std::abs(gram[i][j] - (i == j ? scale2 : 0)) <= sphere_tolerance * scale2)) {
                    refuse_at(e.at,
                              fmt::format("the matrices in force scale x, y, z by {:.6g}, {:.6g}, "
                                          "{:.6g}: this sphere would be an ellipsoid",
                                          std::sqrt(gram[0][0]), std::sqrt(gram[1][1]),
                                          std::sqrt(gram[2][2])));
                }
            }
        }
        const State::Look& look = state.looks[1];
        note_specular(look, 1);
        part_for({look.front, false}, 1, structure)
            .spheres.push_back({placed(state, e.center, structure), e.radius * std::sqrt(scale2)});
        ++content_.spheres;
    }

    void take(const LineElement& e, State& state, const Structure& structure) {
        const State::Look& look = state.looks[2];
        for (std::size_t i = 0; i + 1 < e.points.size(); ++i) {
            part_for({look.front, false}, 1, structure)
                .lines.push_back({placed(state, e.points[i], structure),
                                  placed(state, e.points[i + 1], structure)});
            ++content_.lines;
        }
    }

    glm::dvec3 placed(const State& state, const glm::dvec3& p, const Structure& structure) const {
        const glm::dvec3 at(state.matrix * glm::dvec4(p, 1.0));
        const glm::dvec3 size = glm::abs(at);
        if (!(std::max({size.x, size.y, size.z}) <= max_coordinate)) {
            refuse_at(structure.at, fmt::format("a point of structure {} lies beyond {}",
                                                structure.name, max_coordinate));
        }
        return at;
    }

    void note_specular(const State::Look& look, std::size_t primitives) {
        if (look.has_specular) {
            const auto& [r, g, b] = look.specular.rgb;
            speculars_[{r, g, b, look.specular.power}] += primitives;
        }
    }

    /// The part that takes `count` primitives of this material.
    Part& part_for(const Material& material, std::size_t count, const Structure& structure) {
        primitives_ += count;
        if (primitives_ > std::size_t{max_archive_primitives}) {
            refuse_at(structure.at, fmt::format("more than {} triangles, spheres and lines are "
                                                "drawn, here by structure {}",
                                                max_archive_primitives, structure.name));
        }
        const auto key =
            std::tuple(material.color.r, material.color.g, material.color.b, material.cull_back);
        const auto [found, is_new] = material_index_.emplace(key, content_.materials.size());
        if (is_new) {
            content_.materials.push_back(material);
            open_part_.push_back(parts_.size());
            parts_.emplace_back().material = found->second;
        }
        if (parts_[open_part_[found->second]].primitives() >= primitives_per_part) {
            open_part_[found->second] = parts_.size();
            parts_.emplace_back().material = found->second;
        }
        return parts_[open_part_[found->second]];
    }

    void finish() {
        if (primitives_ == 0) {
            refuse_at({}, content_.posted == 0
                              ? fmt::format("none of {} structures is posted, nothing is drawn",
                                            content_.structures)
                              : "the posted structures draw nothing");
        }
        const std::size_t colors = content_.materials.size();
        const int bits = merge_colors(content_.materials, parts_);
        if (bits < 8) {
            content_.notes.push_back(
                fmt::format("{} colors are drawn as {}: {} bits of each channel are kept", colors,
                            content_.materials.size(), bits));
        }
        join_parts();
        set_specular();
        set_box();
        tell_notes();
    }

    /// In the order of materials, with few small parts: merged colors leave many.
    void join_parts() {
        std::ranges::stable_sort(parts_, {}, &Part::material);
        for (Part& part : parts_) {
            if (content_.parts.empty() || content_.parts.back().material != part.material ||
                content_.parts.back().primitives() + part.primitives() > primitives_per_part) {
                content_.parts.push_back(std::move(part));
                continue;
            }
            Part& last = content_.parts.back();
            const auto first = static_cast<std::uint32_t>(last.vertices.size());
            last.vertices.insert(last.vertices.end(), part.vertices.begin(), part.vertices.end());
            for (const std::uint32_t index : part.indices) {
                last.indices.push_back(first + index);
            }
            last.spheres.insert(last.spheres.end(), part.spheres.begin(), part.spheres.end());
            last.lines.insert(last.lines.end(), part.lines.begin(), part.lines.end());
        }
        parts_.clear();
    }

    void set_specular() {
        std::size_t most = 0;
        for (const auto& [key, count] : speculars_) {
            if (count > most) {
                most = count;
                content_.specular = {{key[0], key[1], key[2]}, key[3]};
                content_.has_specular = true;
            }
        }
        if (speculars_.size() > 1) {
            content_.notes.push_back(
                fmt::format("{} kinds of gloss are drawn as the commonest one", speculars_.size()));
        }
    }

    void tell_notes() {
        const auto note = [this](std::size_t count, const char* text) {
            if (count != 0) {
                content_.notes.push_back(fmt::format("{}: {}", text, count));
            }
        };
        note(archive_.translucent, "translucent colors, drawn opaque");
        note(averaged_, "polygons drawn in the mean of their corners' colors");
        note(flat_polygons_, "polygons left out, as they have no area");
    }

    template <typename Use>
    void for_each_point(const Use& use) const {
        for (const Part& part : content_.parts) {
            for (const ContentVertex& v : part.vertices) {
                use(v.p, 0.0);
            }
            for (const ContentSphere& s : part.spheres) {
                use(s.center, s.radius);
            }
            for (const ContentLine& l : part.lines) {
                use(l.from, 0.0);
                use(l.to, 0.0);
            }
        }
    }

    void set_box() {
        content_.low = glm::dvec3(HUGE_VAL);
        content_.high = glm::dvec3(-HUGE_VAL);
        for_each_point([this](const glm::dvec3& p, double reach) {
            content_.low = glm::min(content_.low, p - reach);
            content_.high = glm::max(content_.high, p + reach);
        });
        for_each_point([this](const glm::dvec3& p, double reach) {
            content_.radius =
                std::max(content_.radius, glm::distance(p, content_.middle()) + reach);
        });
    }

    const Archive& archive_;
    Content content_;
    std::unordered_map<std::string, std::size_t> by_name_;
    std::set<std::size_t> active_;  ///< Structures being executed.
    std::map<std::tuple<int, int, int, bool>, std::size_t> material_index_;
    std::vector<Part> parts_;
    std::vector<std::size_t> open_part_;  ///< One per material.
    std::map<std::array<double, 4>, std::size_t> speculars_;
    std::size_t visits_ = 0, primitives_ = 0, averaged_ = 0, flat_polygons_ = 0;
};

}  // namespace

Content flatten(const Archive& archive) {
    return Flattener(archive).run();
}

}  // namespace pxpl5::host::phigs

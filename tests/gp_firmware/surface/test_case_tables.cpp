#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <map>
#include <set>
#include <utility>

#include "gp_firmware/surface/case_tables.hpp"
#include "gp_firmware/surface/loop_triangulation.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;

namespace {

using Point = std::array<int, 3>;
using Segment = std::pair<int, int>;  ///< From edge to edge.
using Segments = std::multiset<Segment>;

constexpr std::array all_rules = {CaseRule::asymptotic, CaseRule::lorensen1987,
                                  CaseRule::watertight};

/// One entry of a table, by what it stands for.
struct Case {
    unsigned inside, joined;
    const CaseTable& table;
    const CaseEntry& entry() const {
        return table.entry(static_cast<std::uint8_t>(inside), static_cast<std::uint8_t>(joined));
    }
};

/// Calls check(Case) for every corner set and every decision of its ambiguous faces.
template <class Check>
void for_each_case(CaseRule rule, Check check) {
    const CaseTable& table = case_table(rule);
    for (unsigned inside = 0; inside < 256; ++inside)
        for (unsigned joined = 0; joined < 64; ++joined)
            if ((joined & ~unsigned{table.ambiguous[inside]}) == 0) check({inside, joined, table});
}

Point corner_point(int corner) {
    return {corner & 1, corner >> 1 & 1, corner >> 2};
}

/// Twice the midpoint of an edge.
Point midpoint(int edge) {
    const auto [a, b] = edge_corners(edge);
    Point p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = corner_point(a)[i] + corner_point(b)[i];
    return p;
}

bool is_crossed(unsigned inside, int edge) {
    const auto [a, b] = edge_corners(edge);
    return (inside >> a & 1) != (inside >> b & 1);
}

bool on_face(int edge, int face) {
    return midpoint(edge)[static_cast<std::size_t>(face / 2)] == (face % 2) * 2;
}

Segments directed_edges(const Case& c) {
    Segments segments;
    const auto corners = c.table.corners_of(c.entry());
    for (std::size_t i = 0; i < corners.size(); i += 3)
        for (std::size_t j = 0; j < 3; ++j)
            segments.insert({corners[i + j], corners[i + (j + 1) % 3]});
    return segments;
}

/// The directed edges without their opposite: where the cell's triangles end.
Segments rim(const Case& c) {
    const Segments all = directed_edges(c);
    Segments open;
    for (const Segment& s : all)
        if (!all.contains({s.second, s.first})) open.insert(s);
    return open;
}

/// The rim on one face, with edges named by where they are in the face, so that it compares with
/// the neighbor's; the neighbor's runs the other way.
std::set<std::pair<Point, Point>> rim_on_face(const Case& c, int face) {
    std::set<std::pair<Point, Point>> segments;
    for (const auto& [from, to] : rim(c)) {
        if (!on_face(from, face) || !on_face(to, face)) continue;
        Point a = midpoint(from), b = midpoint(to);
        a[static_cast<std::size_t>(face / 2)] = b[static_cast<std::size_t>(face / 2)] = 0;
        if (face % 2 == 0) std::swap(a, b);
        segments.emplace(a, b);
    }
    return segments;
}

/// A face as both of its cells see it: axis, four corners, decision.
std::array<unsigned, 3> face_state(const Case& c, int face) {
    unsigned corners = 0, count = 0;
    for (int corner = 0; corner < 8; ++corner)
        if (corner_point(corner)[static_cast<std::size_t>(face / 2)] == face % 2)
            corners |= (c.inside >> corner & 1) << count++;
    return {static_cast<unsigned>(face / 2), corners, c.joined >> face & 1};
}

/// Face states for which two cells disagree about the surface on the face between them.
std::set<std::array<unsigned, 3>> disagreements(CaseRule rule) {
    std::map<std::array<unsigned, 3>, std::set<std::pair<Point, Point>>> known;
    std::set<std::array<unsigned, 3>> differing;
    for_each_case(rule, [&](const Case& c) {
        for (int face = 0; face < cell_face_count; ++face) {
            const auto state = face_state(c, face);
            const auto [found, added] = known.emplace(state, rim_on_face(c, face));
            if (!added && found->second != rim_on_face(c, face)) differing.insert(state);
        }
    });
    return differing;
}

/// Whether the loop has any triangulation without a diagonal in a face: tries all.
bool can_be_triangulated(const std::vector<std::uint8_t>& loop) {
    if (loop.size() == 3) return true;
    for (std::size_t i = 0; i < loop.size(); ++i) {  // Some corner is an ear.
        const std::size_t next = (i + 1) % loop.size(), after = (i + 2) % loop.size();
        if (share_a_face(loop[i], loop[after])) continue;
        std::vector<std::uint8_t> rest = loop;
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(next));
        if (can_be_triangulated(rest)) return true;
    }
    return false;
}

int dot_with_normal(int face, const Point& along, const Point& toward) {
    const auto axis = static_cast<std::size_t>(face / 2);
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int sign = face % 2 == 1 ? 1 : -1;
    return sign * (along[u] * toward[v] - along[v] * toward[u]);  // normal . (along x toward)
}

}  // namespace

TEST_SUITE("gp/case_tables") {
    TEST_CASE("faces list their corners counter-clockwise seen from outside") {
        for (int face = 0; face < cell_face_count; ++face) {
            const auto corners = face_corners(face);
            for (std::size_t i = 0; i < 4; ++i) {
                Point ab, bc;
                for (std::size_t k = 0; k < 3; ++k) {
                    ab[k] = corner_point(corners[(i + 1) % 4])[k] - corner_point(corners[i])[k];
                    bc[k] = corner_point(corners[(i + 2) % 4])[k] -
                            corner_point(corners[(i + 1) % 4])[k];
                }
                CHECK(dot_with_normal(face, ab, bc) == 1);
                CHECK(corner_point(corners[i])[static_cast<std::size_t>(face / 2)] == face % 2);
            }
        }
    }

    TEST_CASE("every crossed edge has a vertex, no other has, and none is used in two ways") {
        for (const CaseRule rule : all_rules)
            for_each_case(rule, [](const Case& c) {
                const auto corners = c.table.corners_of(c.entry());
                for (int edge = 0; edge < cell_edge_count; ++edge)
                    CHECK((std::count(corners.begin(), corners.end(), edge) > 0) ==
                          is_crossed(c.inside, edge));
                const Segments all = directed_edges(c);
                for (const Segment& s : all) CHECK(all.count(s) == 1);
            });
    }

    TEST_CASE("triangles end on faces only: one step in and one step out at every crossed edge") {
        for (const CaseRule rule : all_rules)
            for_each_case(rule, [](const Case& c) {
                std::map<int, int> out, in;
                for (const auto& [from, to] : rim(c)) {
                    CHECK(from < cell_edge_count);
                    CHECK(to < cell_edge_count);
                    CHECK(share_a_face(from, to));
                    ++out[from];
                    ++in[to];
                }
                for (int edge = 0; edge < cell_edge_count; ++edge) {
                    CHECK(out[edge] == (is_crossed(c.inside, edge) ? 1 : 0));
                    CHECK(in[edge] == out[edge]);
                }
            });
    }

    TEST_CASE("the inside is on the same side of every boundary: all triangles face outwards") {
        for (const CaseRule rule : all_rules)
            for_each_case(rule, [](const Case& c) {
                for (const auto& [from, to] : rim(c))
                    for (int face = 0; face < cell_face_count; ++face) {
                        if (!on_face(from, face) || !on_face(to, face)) continue;
                        const auto ends = edge_corners(from);
                        const bool first_inside = (c.inside >> ends[0] & 1) != 0;
                        const Point corner = corner_point(ends[first_inside ? 0 : 1]);
                        Point along, toward;
                        for (std::size_t i = 0; i < 3; ++i) {
                            along[i] = midpoint(to)[i] - midpoint(from)[i];
                            toward[i] = 2 * corner[i] - midpoint(from)[i];
                        }
                        CHECK(dot_with_normal(face, along, toward) < 0);
                    }
            });
    }

    TEST_CASE("no diagonal lies in a face, where it could meet the neighbor's") {
        for (const CaseRule rule : {CaseRule::asymptotic, CaseRule::watertight})
            for_each_case(rule, [](const Case& c) {
                const Segments all = directed_edges(c);
                for (const auto& [from, to] : all)
                    if (from < cell_edge_count && to < cell_edge_count && all.contains({to, from}))
                        CHECK_FALSE(share_a_face(from, to));
            });
    }

    TEST_CASE("a center vertex stands only where no triangulation does without") {
        int centers = 0;
        for_each_case(CaseRule::asymptotic, [&](const Case& c) {
            const auto ring = c.table.ring_of(c.entry());
            centers += ring.empty() ? 0 : 1;
            if (!ring.empty()) CHECK_FALSE(can_be_triangulated({ring.begin(), ring.end()}));
            const auto corners = c.table.corners_of(c.entry());
            const auto uses = std::count(corners.begin(), corners.end(), center_corner);
            CHECK(uses == static_cast<std::ptrdiff_t>(ring.size()));
        });
        CHECK(centers == case_table(CaseRule::asymptotic).center_count);
        CHECK(case_table(CaseRule::lorensen1987).center_count == 0);
        CHECK(case_table(CaseRule::watertight).center_count == 0);
    }

    TEST_CASE("neighbors agree on every face, whatever their other corners and decisions") {
        CHECK(disagreements(CaseRule::asymptotic).empty());
        CHECK(disagreements(CaseRule::watertight).empty());
    }

    TEST_CASE("neighbors by the 1987 table disagree, on ambiguous faces only") {
        // Opposite corners of the face inside, on any of three axes; decisions play no part.
        std::set<std::array<unsigned, 2>> differing;
        for (const auto& [axis, corners, joined] : disagreements(CaseRule::lorensen1987))
            differing.insert({axis, corners});
        const std::set<std::array<unsigned, 2>> ambiguous = {{0, 0b0110}, {0, 0b1001}, {1, 0b0110},
                                                             {1, 0b1001}, {2, 0b0110}, {2, 0b1001}};
        CHECK(differing == ambiguous);
    }

    TEST_CASE("a joined face differs from a separated one") {
        for_each_case(CaseRule::asymptotic, [](const Case& c) {
            for (int face = 0; face < cell_face_count; ++face) {
                if ((c.table.ambiguous[c.inside] >> face & 1) == 0) continue;
                const Case other{c.inside, c.joined ^ 1U << face, c.table};
                CHECK(rim_on_face(c, face) != rim_on_face(other, face));
            }
        });
    }

    TEST_CASE("the 1987 table is the same for a case and its complement, but for the sense") {
        const CaseTable& table = case_table(CaseRule::lorensen1987);
        for (unsigned inside = 0; inside < 256; ++inside) {
            if (std::popcount(inside) == 4) continue;
            Segments reversed;
            for (const auto& [from, to] : rim({inside ^ 255U, 0, table}))
                reversed.insert({to, from});
            CHECK(rim({inside, 0, table}) == reversed);
        }
    }
}

// Ear clipping. Holes are joined to the loop around them by a bridge, an edge used in both ways.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <optional>
#include <unordered_map>

#include "host/surface/export/plane_cut.hpp"

namespace pxpl5::host {

namespace {

using Point = glm::dvec2;
using Loop = std::vector<std::uint32_t>;

/// Coordinates are whole numbers up to this one, so that turn_at() is exact: below 2^53. Corners
/// on a line are then on a line, and no corner is on both sides of an edge.
constexpr double largest_coordinate = 1 << 25;

double turn_at(const Point& a, const Point& b, const Point& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// The points on the grid of whole numbers, in which the loops take all the room.
std::vector<Point> on_whole_numbers(const std::vector<Point>& points,
                                    const std::vector<Loop>& loops) {
    Point low(std::numeric_limits<double>::max()), high(std::numeric_limits<double>::lowest());
    for (const Loop& loop : loops) {
        for (const std::uint32_t corner : loop) {
            low = glm::min(low, points[corner]);
            high = glm::max(high, points[corner]);
        }
    }
    const double size = std::max(high.x - low.x, high.y - low.y);
    const double scale = size > 0 ? largest_coordinate / size : 1;
    std::vector<Point> out(points.size());
    for (const Loop& loop : loops) {
        for (const std::uint32_t corner : loop) {
            out[corner] = glm::round((points[corner] - low) * scale);
        }
    }
    return out;
}

class Clipper {
  public:
    Clipper(const std::vector<Point>& points, const std::vector<Loop>& loops)
        : points_(on_whole_numbers(points, loops)) {}

    LoopTriangles run(const std::vector<Loop>& loops) {
        std::vector<Loop> outer, holes;
        for (const Loop& loop : loops) {
            for (std::size_t i = 0; i < loop.size(); ++i) {
                ++uses_[pair_of(loop[i], loop[(i + 1) % loop.size()])];
            }
            corners_ += loop.size();
            (area(loop) > 0 ? outer : holes).push_back(loop);
        }
        // Small loops first, so that a hole finds the innermost loop around it; holes from right to
        // left, so that a bridge to the right meets the loop or a hole that was joined before.
        std::ranges::sort(outer, {}, [&](const Loop& loop) { return area(loop); });
        std::ranges::sort(holes, std::greater{},
                          [&](const Loop& hole) { return points_[rightmost(hole)].x; });
        const std::vector<Loop> around = outer;
        for (const Loop& hole : holes) {
            const Point& p = points_[hole.front()];
            const auto at =
                std::ranges::find_if(around, [&](const Loop& loop) { return contains(loop, p); });
            if (at == around.end()) {
                outer.push_back(hole);
            } else {
                join(outer[static_cast<std::size_t>(at - around.begin())], hole);
            }
        }
        for (Loop& loop : outer) {
            clip(loop);
        }
        return std::move(out_);
    }

  private:
    static std::uint64_t pair_of(std::uint32_t a, std::uint32_t b) {
        const auto [low, high] = std::minmax(a, b);
        return std::uint64_t{low} << 32 | high;
    }

    double area(const Loop& loop) const {
        double sum = 0;
        for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
            sum += turn_at(points_[loop[0]], points_[loop[i]], points_[loop[i + 1]]);
        }
        return sum / 2;
    }

    std::uint32_t rightmost(const Loop& loop) const {
        return *std::ranges::max_element(loop, {}, [&](auto v) { return points_[v].x; });
    }

    bool contains(const Loop& loop, const Point& p) const {
        bool is_inside = false;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Point &a = points_[loop[i]], &b = points_[loop[(i + 1) % loop.size()]];
            const bool is_upward = b.y > a.y;
            // The ray to the right passes just above corners at the height of p.
            if ((a.y > p.y) != (b.y > p.y) && (turn_at(a, b, p) > 0) == is_upward) {
                is_inside = !is_inside;
            }
        }
        return is_inside;
    }

    /// The first corner of the side that the ray from `p` to the right meets first. The area is at
    /// the left of its sides, so it is a side upward.
    std::optional<std::size_t> side_right_of(const Point& p, const Loop& loop) const {
        double nearest = std::numeric_limits<double>::infinity();
        std::optional<std::size_t> best;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Point &a = points_[loop[i]], &b = points_[loop[(i + 1) % loop.size()]];
            if (a.y > p.y || b.y <= p.y || turn_at(a, b, p) <= 0) continue;
            const double x = a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y);
            if (x < nearest) {
                nearest = x;
                best = i;
            }
        }
        return best;
    }

    /// The place in `loop` of a corner that can be seen from `p`.
    std::size_t visible_from(const Point& p, const Loop& loop) const {
        const std::size_t side = side_right_of(p, loop).value_or(0);
        const std::size_t end = (side + 1) % loop.size();
        const Point &a = points_[loop[side]], &b = points_[loop[end]];
        std::size_t best = a.x > b.x ? side : end;
        // Another corner may lie between that one, the ray and the side. The corner at the least
        // angle to the ray is seen, the nearer one of two at the same angle.
        const Point seen = points_[loop[best]];
        const bool is_above = seen.y > p.y;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Point &q = points_[loop[i]], &r = points_[loop[best]];
            const double turn = turn_at(p, seen, q);
            const bool is_between = is_above ? q.y >= p.y && turn <= 0 : q.y <= p.y && turn >= 0;
            if (q.x <= p.x || !is_between || turn_at(a, b, q) < 0) continue;
            const double angle = std::abs(q.y - p.y) * (r.x - p.x),
                         least = std::abs(r.y - p.y) * (q.x - p.x);
            if (angle < least || (angle == least && q.x < r.x)) best = i;
        }
        // A corner that has a bridge is in the loop twice, each time with another side.
        for (std::size_t i = 0; i < loop.size(); ++i) {
            if (points_[loop[i]] == points_[loop[best]] && is_inside_at(loop, i, p)) {
                return i;
            }
        }
        return best;
    }

    /// Whether the way from corner `at` to `p` begins inside the loop.
    bool is_inside_at(const Loop& loop, std::size_t at, const Point& p) const {
        const std::size_t n = loop.size();
        const Point &a = points_[loop[(at + n - 1) % n]], &b = points_[loop[at]],
                    &c = points_[loop[(at + 1) % n]];
        const bool is_left_before = turn_at(a, b, p) > 0, is_left_after = turn_at(b, c, p) > 0;
        return turn_at(a, b, c) > 0 ? is_left_before && is_left_after
                                    : is_left_before || is_left_after;
    }

    void join(Loop& loop, const Loop& hole) {
        const auto from = std::ranges::find(hole, rightmost(hole));
        const auto at = static_cast<std::ptrdiff_t>(visible_from(points_[*from], loop));
        const std::uint32_t seen = loop[static_cast<std::size_t>(at)];
        ++uses_[pair_of(*from, seen)];
        Loop bridge(from, hole.end());
        bridge.insert(bridge.end(), hole.begin(), from + 1);
        bridge.push_back(seen);
        loop.insert(loop.begin() + at + 1, bridge.begin(), bridge.end());
    }

    bool is_ear(const std::vector<std::size_t>& after, std::size_t before, std::size_t at,
                const Loop& loop) const {
        const Point &a = points_[loop[before]], &b = points_[loop[at]],
                    &c = points_[loop[after[at]]];
        if (!(turn_at(a, b, c) > 0)) return false;
        const Point low = glm::min(a, glm::min(b, c)), high = glm::max(a, glm::max(b, c));
        for (std::size_t i = after[after[at]]; i != before; i = after[i]) {
            const Point& p = points_[loop[i]];
            if (p.x < low.x || p.x > high.x || p.y < low.y || p.y > high.y) continue;
            if (p != a && p != b && p != c && turn_at(a, b, p) >= 0 && turn_at(b, c, p) >= 0 &&
                turn_at(c, a, p) >= 0) {
                return false;
            }
        }
        return true;
    }

    void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        // Two sides of such a triangle are one edge, which then has the triangles beyond them.
        if (a != b && b != c && c != a) out_.triangles.push_back({a, b, c});
    }

    /// A new corner on the edge from a to b, which other triangles have already.
    std::uint32_t add_between(std::uint32_t a, std::uint32_t b, int uses) {
        const double share = 1.0 / (uses + 1);
        out_.added.push_back({a, b, share});
        points_.push_back(glm::mix(points_[a], points_[b], share));
        const auto middle = static_cast<std::uint32_t>(points_.size() - 1);
        ++uses_[pair_of(a, middle)];
        ++uses_[pair_of(b, middle)];
        return middle;
    }

    /// Whether the corner may go after `tried` others of the `left` corners did not. Loops that
    /// touch or cross themselves may run out of ears: then corners on a straight line go, then any.
    bool may_go(const std::vector<std::size_t>& after, std::size_t before, std::size_t left,
                std::size_t tried, const Loop& loop) const {
        const std::size_t at = after[before];
        const std::uint32_t a = loop[before], b = loop[at], c = loop[after[at]];
        const auto known = uses_.find(pair_of(a, c));
        const bool is_new = a == c || known == uses_.end();
        if (left == 3 || tried > 3 * left) return true;
        if (tried > 2 * left) return is_new;
        if (tried > left && is_new && turn_at(points_[a], points_[b], points_[c]) == 0) return true;
        return (is_new || tried > left) && is_ear(after, before, at, loop);
    }

    void clip(Loop& loop) {
        std::size_t left = loop.size(), before = left - 1, tried = 0;
        std::vector<std::size_t> after(left);
        for (std::size_t i = 0; i < left; ++i) {
            after[i] = (i + 1) % left;
        }
        for (; left > 2; ++tried) {
            if (may_go(after, before, left, tried, loop)) {
                const std::size_t at = after[before], next = after[at];
                const std::uint32_t a = loop[before], b = loop[at], c = loop[next];
                const int uses = left == 3 || a == c ? 0 : uses_[pair_of(a, c)]++;
                tried = 0;
                if (uses > 0 && out_.added.size() < corners_) {
                    const std::uint32_t middle = add_between(a, c, uses);
                    ++uses_[pair_of(b, middle)];
                    add_triangle(a, b, middle);
                    add_triangle(b, c, middle);
                    loop[at] = middle;
                } else {
                    add_triangle(a, b, c);
                    after[before] = next;
                    --left;
                }
            }
            before = after[before];
        }
    }

    std::vector<Point> points_;
    /// Number of loops, bridges and edges between triangles that have each edge.
    std::unordered_map<std::uint64_t, int> uses_;
    std::size_t corners_ = 0;  ///< Corners of all loops, and limit of the added corners.
    LoopTriangles out_;
};

}  // namespace

LoopTriangles triangulate_loops(const std::vector<glm::dvec2>& points,
                                const std::vector<std::vector<std::uint32_t>>& loops) {
    return Clipper(points, loops).run(loops);
}

}  // namespace pxpl5::host

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <set>

#include "generated/vocabulary.hpp"
#include "host/base/error.hpp"
#include "host/phigs/lexer.hpp"

namespace pxpl5::host::phigs {

namespace {

constexpr double max_archive_power = 1e6;
constexpr std::size_t flags_plain = 3;  ///< Value that both writers of 1993 use.
constexpr std::size_t flag_cull_back = 128;
constexpr std::string_view element_words =
    "'polygon', 'polygon5', 'sphere', 'line', 'color', 'matrix', 'execute' or '}'";

class Parser {
  public:
    Parser(std::string_view text, const std::string& file) : lexer_(text, file) {
        archive_.file = file;
    }

    Archive run() {
        while (!lexer_.at_end()) {
            archive_.structures.push_back(structure());
        }
        return std::move(archive_);
    }

  private:
    Structure structure() {
        const Place at = lexer_.peek().at;
        lexer_.expect("structure", "at the top level");
        if (archive_.structures.size() == std::size_t{max_archive_structures}) {
            lexer_.refuse_at(at, fmt::format("{} structures are the most", max_archive_structures));
        }
        Structure result;
        const Place name_at = lexer_.peek().at;
        result.name = name("a structure's name");
        result.at = at;
        if (!names_.insert(result.name).second) {
            lexer_.refuse_at(name_at, fmt::format("structure {} is there twice", result.name));
        }
        result.posted = lexer_.take_if("posted");
        lexer_.expect("{", result.posted ? "behind posted" : "or 'posted' behind the name");
        while (!lexer_.take_if("}")) {
            if (++element_count_ > max_elements) {
                lexer_.refuse_at(lexer_.peek().at,
                                 fmt::format("{} elements are the most", max_elements));
            }
            result.elements.push_back(element());
        }
        lexer_.take_if(";");
        return result;
    }

    std::string name(std::string_view what) {
        const std::string_view text = lexer_.peek().text;
        if (text.empty() || text == "{" || text == "}" || text == ";") {
            lexer_.unexpected(what);
        }
        if (text.size() > max_name_length) {
            lexer_.refuse_at(lexer_.peek().at, fmt::format("{} has {} characters, {} are the most",
                                                           what, text.size(), max_name_length));
        }
        return std::string(lexer_.next().text);
    }

    Element element() {
        if (lexer_.take_if("polygon")) {
            return polygon();
        }
        if (lexer_.take_if("polygon5")) {
            return polygon5();
        }
        const Place at = lexer_.peek().at;
        if (lexer_.take_if("sphere")) {
            return sphere(at);
        }
        if (lexer_.take_if("line")) {
            return line();
        }
        if (lexer_.take_if("color")) {
            return color();
        }
        if (lexer_.take_if("matrix")) {
            return matrix();
        }
        if (lexer_.take_if("execute")) {
            ExecuteElement execute;
            execute.at = lexer_.peek().at;
            execute.name = name("the name of a structure to execute");
            lexer_.expect(";", "behind the name");
            return execute;
        }
        lexer_.unexpected(element_words);
    }

    double coordinate(std::string_view what) {
        return lexer_.number(what, -max_number, max_number);
    }

    glm::dvec3 vector(std::string_view x, std::string_view y, std::string_view z) {
        glm::dvec3 v;
        v.x = coordinate(x);
        v.y = coordinate(y);
        v.z = coordinate(z);
        return v;
    }
    glm::dvec3 point() { return vector("x", "y", "z"); }

    Color rgba() {
        const auto part = [this](std::string_view what) {
            return static_cast<std::uint8_t>(std::lround(lexer_.number(what, 0, 255)));
        };
        Color color;
        color.r = part("red");
        color.g = part("green");
        color.b = part("blue");
        archive_.translucent += part("alpha") != 255 ? 1 : 0;
        return color;
    }

    /// Corners up to the closing brace. Braces and counts are as the callers say.
    void corners(PolygonElement& polygon, std::size_t count, bool own_colors) {
        const Place at = lexer_.peek().at;
        lexer_.expect("{", "before the corners");
        while (lexer_.peek().text != "}") {
            if (polygon.corners.size() == count) {
                lexer_.unexpected(fmt::format("'}}' behind {} corners", count));
            }
            polygon.corners.push_back(corner(polygon, own_colors));
        }
        if (polygon.corners.size() != count) {
            lexer_.refuse_at(at, fmt::format("{} corners are given, {} were announced",
                                             polygon.corners.size(), count));
        }
        lexer_.expect("}", "behind the corners");
        lexer_.take_if(";");
    }

    Corner corner(PolygonElement& polygon, bool own_colors) {
        const Place at = lexer_.peek().at;
        Corner corner;
        corner.p = point();
        const bool has_normal = lexer_.number_ahead();
        if (has_normal) {
            corner.normal = vector("nx", "ny", "nz");
        }
        if (polygon.corners.empty()) {
            polygon.has_normals = has_normal;
        } else if (polygon.has_normals != has_normal) {
            lexer_.refuse_at(at, fmt::format("this corner has {} normal, the first one has {}",
                                             has_normal ? "a" : "no", has_normal ? "none" : "one"));
        }
        if (own_colors && lexer_.take_if("diff")) {
            corner.diffuse = rgba();
        }
        lexer_.expect(";", own_colors ? "or 'diff' behind a corner" : "behind a corner");
        return corner;
    }

    PolygonElement polygon() {
        PolygonElement result;
        corners(result, lexer_.count("number of corners", 3, max_polygon_corners), false);
        return result;
    }

    PolygonElement polygon5() {
        PolygonElement result;
        const std::size_t count = lexer_.count("number of corners", 3, max_polygon_corners);
        const Place at = lexer_.peek().at;
        const std::size_t flags = lexer_.count("flags", 0, 65'535);
        if (flags != flags_plain && flags != (flags_plain | flag_cull_back)) {
            lexer_.refuse_at(
                at, fmt::format("flags are {}, known are {} and {} (back faces culled)", flags,
                                flags_plain, flags_plain | flag_cull_back));
        }
        result.cull_back = flags != flags_plain;
        if (lexer_.take_if("diff")) {
            result.diffuse = rgba();
        }
        corners(result, count, true);
        return result;
    }

    SphereElement sphere(Place at) {
        SphereElement result;
        result.at = at;
        result.center = point();
        const Place radius_at = lexer_.peek().at;
        result.radius = lexer_.number("radius", 0, max_number);
        if (result.radius == 0) {
            lexer_.refuse_at(radius_at, "radius is 0, it must be more");
        }
        lexer_.expect(";", "behind a sphere");
        return result;
    }

    LineElement line() {
        LineElement result;
        const std::size_t count = lexer_.count("number of points", 2, max_line_points);
        const Place at = lexer_.peek().at;
        lexer_.expect("{", "before the points");
        while (lexer_.peek().text != "}") {
            if (result.points.size() == count) {
                lexer_.unexpected(fmt::format("'}}' behind {} points", count));
            }
            result.points.push_back(point());
            lexer_.expect(";", "behind a point");
        }
        if (result.points.size() != count) {
            lexer_.refuse_at(at, fmt::format("{} points are given, {} were announced",
                                             result.points.size(), count));
        }
        lexer_.expect("}", "behind the points");
        lexer_.take_if(";");
        return result;
    }

    Specular specular() {
        Specular s;
        s.rgb = {lexer_.number("red", 0, 255), 0, 0};
        s.rgb[1] = lexer_.number("green", 0, 255);
        s.rgb[2] = lexer_.number("blue", 0, 255);
        s.power = lexer_.number("power", 0, max_archive_power);
        return s;
    }

    ColorElement color() {
        ColorElement result;
        const auto kind = std::ranges::find(kind_names, lexer_.peek().text);
        if (kind == kind_names.end()) {
            lexer_.unexpected("'polygon', 'sphere' or 'line' behind color");
        }
        result.kind = static_cast<Kind>(kind - kind_names.begin());
        lexer_.next();
        lexer_.expect("{", "before the colors");
        while (!lexer_.take_if("}")) {
            if (lexer_.take_if("diff")) {
                const Color front = rgba();
                result.diffuse = {front, lexer_.number_ahead() ? rgba() : front};
            } else if (lexer_.take_if("spec")) {
                result.specular = specular();
                if (lexer_.number_ahead()) {
                    specular();  // The back's: the frame has one only.
                }
            } else if (!lexer_.take_if(";")) {
                lexer_.unexpected("'diff', 'spec' or '}'");
            }
        }
        lexer_.take_if(";");
        return result;
    }

    MatrixElement matrix() {
        MatrixElement result;
        lexer_.expect("Pre", "behind matrix");
        if (lexer_.take_if("scale")) {
            const Place at = lexer_.peek().at;
            const glm::dvec3 s = vector("sx", "sy", "sz");
            if (s.x == 0 || s.y == 0 || s.z == 0) {
                lexer_.refuse_at(at, "a scale of 0 leaves nothing to draw");
            }
            result.matrix = glm::scale(result.matrix, s);
        } else if (lexer_.take_if("translate")) {
            result.matrix = glm::translate(result.matrix, point());
        } else if (lexer_.take_if("rotate")) {
            result.matrix = rotation();
        } else {
            lexer_.unexpected("'scale', 'translate' or 'rotate' behind Pre");
        }
        lexer_.expect(";", "behind a matrix");
        return result;
    }

    glm::dmat4 rotation() {
        glm::dvec3 axis(0);
        const std::string_view text = lexer_.peek().text;
        if (text != "x" && text != "y" && text != "z") {
            lexer_.unexpected("an axis: 'x', 'y' or 'z'");
        }
        axis[text[0] - 'x'] = 1;
        lexer_.next();
        const double degrees = coordinate("angle in degrees");
        return glm::rotate(glm::dmat4(1.0), degrees / 180 * glm::pi<double>(), axis);
    }

    Lexer lexer_;
    Archive archive_;
    std::set<std::string> names_;
    std::size_t element_count_ = 0;
};

}  // namespace

Archive parse_archive(std::string_view text, const std::string& file) {
    return Parser(text, file).run();
}

Archive read_archive(const std::string& path) {
    const auto refuse = [&path](const std::string& reason) {
        throw RequestError(ExitCode::bad_data, fmt::format("{}: {}", path, reason));
    };
    // O_NONBLOCK: a FIFO without a writer would block here for ever.
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (file < 0) {
        refuse(fmt::format("cannot be opened: {}", std::strerror(errno)));
    }
    const std::shared_ptr<void> closer(nullptr, [file](void*) { ::close(file); });
    struct stat facts {};
    if (fstat(file, &facts) != 0 || !S_ISREG(facts.st_mode)) {
        refuse("is no regular file");
    }
    if (static_cast<std::uint64_t>(facts.st_size) > max_file_bytes) {
        refuse(fmt::format("has {} bytes, {} are the most", facts.st_size, max_file_bytes));
    }
    std::string text(static_cast<std::size_t>(facts.st_size), '\0');
    for (std::size_t done = 0; done < text.size();) {
        const ssize_t got = ::read(file, text.data() + done, text.size() - done);
        if (got == 0 || (got < 0 && errno != EINTR)) {
            refuse("cannot be read");
        }
        done += static_cast<std::size_t>(std::max<ssize_t>(got, 0));
    }
    return parse_archive(text, path);
}

}  // namespace pxpl5::host::phigs

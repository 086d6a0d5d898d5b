#include "host/commands/pictures/picture_files.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>

#include "host/base/command_line.hpp"
#include "host/base/part_file.hpp"
#include "host/commands/text/picture_text.hpp"

namespace pxpl5::host {

namespace {

constexpr int max_animation_frames = 2'000;

}  // namespace

bool is_blank(const Picture& picture) {
    return std::ranges::count(picture.rgba, picture.rgba[0]) == std::ssize(picture.rgba);
}

PictureFiles::PictureFiles(Session& session, const Arguments& arguments, std::size_t at, int count,
                           double usual_ms)
    : session_(session),
      count_(count),
      delay_ms_(arguments.number("delay_ms", usual_ms)),
      rate_(arguments.number("rate", 1000 / usual_ms)) {
    if (arguments.words.size() > at) {
        pattern_ = arguments.words[at];
    }
    is_animation_ = suffix_of(pattern_) == ".gif";
    is_film_ = suffix_of(pattern_) == ".webm";
    if (!pattern_.empty() && !is_animation_ && !is_film_ &&
        pattern_.find("{}") == std::string::npos) {
        refuse_command(fmt::format(
            "{}: '{}' is no .webm or .gif and has no {{}} where the frame's number goes",
            arguments.name, pattern_));
    }
    if ((is_animation_ || is_film_) && pattern_.find("{}") != std::string::npos) {
        refuse_command(
            fmt::format("{}: {} is one file, but has {{}} for the number of a picture. Leave {{}} "
                        "out, or write a .png for each picture",
                        arguments.name, pattern_));
    }
    if (is_animation_ && count > max_animation_frames) {
        refuse_command(
            fmt::format("{}: {} frames are too many for {}, {} are the most. Write a .webm",
                        arguments.name, count, pattern_, max_animation_frames));
    }
    check_options(arguments);
}

void PictureFiles::check_options(const Arguments& arguments) const {
    if (arguments.has("rate") && !is_film_) {
        refuse_command(
            fmt::format("{}: rate is the frames per second of a .webm; a .gif has "
                        "delay_ms",
                        arguments.name));
    }
    if (arguments.has("delay_ms") && is_film_) {
        refuse_command(
            fmt::format("{}: delay_ms is the time between the pictures of a .gif; a "
                        ".webm has rate, for example rate={:g}",
                        arguments.name, 1000 / delay_ms_));
    }
}

void PictureFiles::take(int index, const Picture& picture, const Camera& camera) {
    is_blank_ = is_blank_ && !pattern_.empty() && is_blank(picture);
    if (is_film_) {
        add_to_film(picture);
    } else if (is_animation_) {
        pictures_.push_back(picture);
    } else if (!pattern_.empty()) {
        std::string path = pattern_;
        path.replace(path.find("{}"), 2,
                     fmt::format("{:04}", range_.volumes ? range_.volumes->first + index : index));
        session_.exports.pictures({&picture, 1}, path, picture_extras(session_, camera));
        ++written_;
    }
    if (session_.tell_pictures) {
        session_.tell_pictures(index + 1, count_);
    }
}

/// The first picture decides the size of the film, which has both eyes in stereo.
void PictureFiles::add_to_film(const Picture& picture) {
    if (!film_) {
        const PictureExtras extras = animation_extras(session_, range_);
        const std::string title = session_.volumes.has_volume() ? session_.volumes.volume().name
                                                                : session_.volumes.archive()->file;
        film_.emplace(pattern_, film::FilmForm{picture.width, picture.height, rate_, title,
                                               extras.description});
    }
    film_->add({picture.rgba.data(), picture.rgba.size()});
}

void PictureFiles::finish() {
    if (film_) {
        film_->keep();
        written_ = 1;
    } else if (is_animation_) {
        PictureExtras extras = animation_extras(session_, range_);
        extras.delay_ms = static_cast<int>(delay_ms_);
        session_.exports.pictures(pictures_, pattern_, extras);
        written_ = 1;
    }
}

void PictureFiles::add_files(Reply& reply) const {
    if (!pattern_.empty()) {
        reply.fields.push_back({is_film_ || is_animation_ ? "file" : "files", pattern_});
    }
    if (film_) {
        reply.fields.push_back({"rate", rate_});
        reply.fields.push_back({"duration_s", count_ / rate_});
    }
}

void PictureFiles::warn(Reply& reply) const {
    if (is_blank_ && written_ != 0) {
        add_warning(reply, "nothing is visible in any of the pictures", "; ");
    }
}

std::string PictureFiles::text() const {
    return film_ ? fmt::format("; wrote {} ({:.1f} s, {:g} frames/s)", pattern_, count_ / rate_,
                               rate_)
           : has_interrupted() ? fmt::format("; wrote {} ({} pictures)", pattern_, written_)
           : written_ != 0     ? "; wrote " + pattern_
                               : "";
}

}  // namespace pxpl5::host

// The files of a command that draws many pictures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/base/command_descriptor.hpp"
#include "host/base/reply.hpp"
#include "host/commands/text/picture_text.hpp"
#include "host/film/film.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

/// Whether all pixels are equal: nothing but the background.
bool is_blank(const Picture& picture);

inline constexpr double usual_delay_ms = 40;

/// Where the pictures of a command go: nowhere, into a file each, into an animation, or into a
/// film.
class PictureFiles {
  public:
    /// Refuses the command if its `at`-th word, which may be missing, names no such place, or if an
    /// option belongs to another kind of file.
    /// usual_ms  Time between the pictures of a film or an animation, unless an option states it.
    PictureFiles(Session& session, const Arguments& arguments, std::size_t at, int count,
                 double usual_ms = usual_delay_ms);

    /// The pictures show a surface at several isovalues. Call this before take().
    void set_swept(SweptSurface swept) { range_.swept = std::move(swept); }
    /// The pictures show these volumes of a time series. Call this before take().
    void set_volumes(ShownVolumes volumes) { range_.volumes = volumes; }
    void take(int index, const Picture& picture, const Camera& camera);
    /// Writes the animation or the end of the film, if it is one.
    void finish();
    std::int64_t written() const { return written_; }
    /// Adds where the pictures are, and what the reply says of a film.
    void add_files(Reply& reply) const;
    /// Adds a warning if pictures were written in which nothing is visible.
    void warn(Reply& reply) const;
    /// Whether files were written between the pictures: times then tell of writing.
    bool has_interrupted() const { return film_.has_value() || (written_ != 0 && !is_animation_); }
    /// For the end of the command's answer.
    std::string text() const;

  private:
    void check_options(const Arguments& arguments) const;
    void add_to_film(const Picture& picture);

    Session& session_;
    int count_;
    double delay_ms_, rate_;
    std::string pattern_;
    bool is_animation_ = false, is_film_ = false, is_blank_ = true;
    std::int64_t written_ = 0;
    std::vector<Picture> pictures_;
    AnimationRange range_;
    std::optional<film::Film> film_;
};

}  // namespace pxpl5::host

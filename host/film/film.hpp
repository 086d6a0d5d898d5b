// A film: pictures as a WebM file that browsers and players show.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace pxpl5::host::film {

inline constexpr double min_rate = 1, max_rate = 60, usual_rate = 25;  ///< Pictures per second.

struct FilmForm {
    int width = 0, height = 0;
    double rate = usual_rate;
    std::string title, comment;  ///< Texts of the file.
};

/// Writes a film while its pictures are drawn. The file appears when it is whole; without keep()
/// there is none. Encodes VP8 (RFC 6386) of constant quality. The same pictures give the same
/// bytes.
class Film {
  public:
    /// Throws RequestError if the file cannot be made, or if this build writes no films.
    Film(const std::filesystem::path& target, const FilmForm& form);
    ~Film();
    Film(const Film&) = delete;
    Film& operator=(const Film&) = delete;

    /// Adds the next picture. Throws RequestError with the reason if it cannot be written.
    ///
    /// rgba  Pixels of the film's size, top row first, red in the low byte; alpha has no effect.
    void add(std::span<const std::uint32_t> rgba);
    /// Ends the film, which has a picture at least. Throws RequestError.
    void keep();

  private:
    class Parts;
    std::filesystem::path target_;
    std::unique_ptr<Parts> parts_;
};

}  // namespace pxpl5::host::film

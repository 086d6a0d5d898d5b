// A build without films.
#include "host/base/error.hpp"
#include "host/film/film.hpp"

namespace pxpl5::host::film {

class Film::Parts {};

Film::Film(const std::filesystem::path& target, const FilmForm& /*form*/) {
    throw RequestError(ExitCode::failed,
                       target.string() +
                           ": this build writes no films (PXPL5_FILM=OFF). Write a "
                           ".gif, or build with libvpx and FFmpeg's libavformat");
}
Film::~Film() = default;
void Film::add(std::span<const std::uint32_t> /*rgba*/) {}
void Film::keep() {}

}  // namespace pxpl5::host::film

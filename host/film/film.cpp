#include "host/film/film.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "host/base/error.hpp"
#include "host/base/part_file.hpp"
#include "host/film/film_encoder.hpp"
#include "host/film/webm_file.hpp"

namespace pxpl5::host::film {

/// Encodes pictures and writes them into the file.
class Film::Parts {
  public:
    Parts(const std::filesystem::path& target, const FilmForm& form)
        : rate_(form.rate), file_(target), encoder_(form), webm_(file_, form) {}

    void add(std::span<const std::uint32_t> rgba) {
        const std::int64_t begin = time_of(pictures_), end = time_of(++pictures_);
        const VideoPacket packet = encoder_.encode(rgba, begin, end - begin);
        webm_.add(packet.bytes, packet.is_key, begin, end - begin);
    }
    void keep() {
        webm_.finish();
        if (const std::string reason = file_.keep(); !reason.empty()) {
            throw std::runtime_error(reason);
        }
    }

  private:
    std::int64_t time_of(std::int64_t picture) const {
        return std::llround(static_cast<double>(picture) * ticks_per_second / rate_);
    }

    double rate_;
    std::int64_t pictures_ = 0;
    PartFile file_;
    FilmEncoder encoder_;
    WebmFile webm_;
};

namespace {

/// Calls `act`. Its errors become those of the request, with the file's name.
template <typename Act>
auto for_file(const std::filesystem::path& target, const Act& act) {
    try {
        return act();
    } catch (const std::runtime_error& error) {
        throw RequestError(ExitCode::failed,
                           fmt::format("cannot write {}: {}", target.string(), error.what()));
    }
}

}  // namespace

Film::Film(const std::filesystem::path& target, const FilmForm& form) : target_(target) {
    if (const std::string wrong = wrong_place(target); !wrong.empty()) {
        throw RequestError(ExitCode::usage, wrong);
    }
    remove_abandoned_parts(target);
    parts_ = for_file(target_, [&] { return std::make_unique<Parts>(target, form); });
}

Film::~Film() = default;

void Film::add(std::span<const std::uint32_t> rgba) {
    for_file(target_, [&] { parts_->add(rgba); });
}

void Film::keep() {
    for_file(target_, [&] { parts_->keep(); });
}

}  // namespace pxpl5::host::film

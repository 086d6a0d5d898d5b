// Films, read back by WebM's own parser and libvpx's decoder.
#include <doctest/doctest.h>
#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>
#include <webm/callback.h>
#include <webm/file_reader.h>
#include <webm/webm_parser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/film/film.hpp"

using namespace pxpl5::host;
using film::Film;
using film::FilmForm;
namespace fs = std::filesystem;

namespace {

using Pixels = std::vector<std::uint32_t>;

/// A folder that goes with the test.
struct Folder {
    Folder() {
        std::string name = (fs::temp_directory_path() / "pxpl5-film-XXXXXX").string();
        REQUIRE(mkdtemp(name.data()) != nullptr);
        path = name;
    }
    ~Folder() { fs::remove_all(path); }
    std::vector<std::string> names() const {
        std::vector<std::string> found;
        for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
            found.push_back(entry.path().filename());
        }
        return found;
    }
    fs::path path;
};

/// A ramp of colors with a bright disk that moves from picture to picture.
Pixels picture(int width, int height, int number) {
    Pixels pixels;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const int dx = x - 10 - 8 * number, dy = y - height / 2;
            const bool is_disk = dx * dx + dy * dy < 64;
            const int red = is_disk ? 230 : 40 + 100 * x / width;
            const int green = is_disk ? 220 : 60 + 80 * y / height, blue = is_disk ? 200 : 90;
            pixels.push_back(0xff000000U | static_cast<std::uint32_t>(blue) << 16U |
                             static_cast<std::uint32_t>(green) << 8U |
                             static_cast<std::uint32_t>(red));
        }
    }
    return pixels;
}

/// Red, green and blue by ITU-R BT.601, where black is 16 and white 235.
std::array<double, 3> color_of(const vpx_image_t& image, unsigned x, unsigned y) {
    const auto at = [&](int plane, unsigned column, unsigned row) {
        return static_cast<double>(
            *(image.planes[plane] + row * static_cast<unsigned>(image.stride[plane]) + column));
    };
    const double light = 1.164383 * (at(VPX_PLANE_Y, x, y) - 16);
    const double blue = at(VPX_PLANE_U, x / 2, y / 2) - 128,
                 red = at(VPX_PLANE_V, x / 2, y / 2) - 128;
    return {light + 1.596027 * red, light - 0.391762 * blue - 0.812968 * red,
            light + 2.017232 * blue};
}

/// A file as a player reads it.
class Played : public webm::Callback {
  public:
    explicit Played(const fs::path& path) {
        REQUIRE(vpx_codec_dec_init(&decoder_, vpx_codec_vp8_dx(), nullptr, 0) == VPX_CODEC_OK);
        std::FILE* file = std::fopen(path.c_str(), "rb");
        REQUIRE(file != nullptr);
        webm::FileReader reader(file);  // Closes the file.
        webm::WebmParser parser;
        REQUIRE(parser.Feed(this, &reader).completed_ok());
    }
    ~Played() override { vpx_codec_destroy(&decoder_); }

    webm::Status OnInfo(const webm::ElementMetadata& /*at*/, const webm::Info& info) override {
        duration_ms =
            info.duration.value() * static_cast<double>(info.timecode_scale.value()) / 1e6;
        title = info.title.value();
        return webm::Status(webm::Status::kOkCompleted);
    }
    webm::Status OnTrackEntry(const webm::ElementMetadata& /*at*/,
                              const webm::TrackEntry& track) override {
        codec = track.codec_id.value();
        width = track.video.value().pixel_width.value();
        height = track.video.value().pixel_height.value();
        return webm::Status(webm::Status::kOkCompleted);
    }
    webm::Status OnClusterBegin(const webm::ElementMetadata& /*at*/, const webm::Cluster& cluster,
                                webm::Action* action) override {
        cluster_ms_ = static_cast<std::int64_t>(cluster.timecode.value());
        *action = webm::Action::kRead;
        return webm::Status(webm::Status::kOkCompleted);
    }
    webm::Status OnSimpleBlockBegin(const webm::ElementMetadata& /*at*/,
                                    const webm::SimpleBlock& block, webm::Action* action) override {
        keys.push_back(block.is_key_frame);
        return begin(block.timecode, action);
    }
    webm::Status OnBlockBegin(const webm::ElementMetadata& /*at*/, const webm::Block& block,
                              webm::Action* action) override {
        keys.push_back(false);
        return begin(block.timecode, action);
    }
    webm::Status OnCuePoint(const webm::ElementMetadata& /*at*/,
                            const webm::CuePoint& cue) override {
        cues_ms.push_back(static_cast<std::int64_t>(cue.time.value()));
        return webm::Status(webm::Status::kOkCompleted);
    }
    webm::Status OnFrame(const webm::FrameMetadata& /*at*/, webm::Reader* reader,
                         std::uint64_t* bytes_remaining) override {
        std::vector<std::uint8_t> bytes(*bytes_remaining);
        std::uint64_t count = 0;
        const webm::Status status = reader->Read(bytes.size(), bytes.data(), &count);
        *bytes_remaining -= count;
        REQUIRE(*bytes_remaining == 0);
        REQUIRE(vpx_codec_decode(&decoder_, bytes.data(), static_cast<unsigned>(count), nullptr,
                                 0) == VPX_CODEC_OK);
        vpx_codec_iter_t next = nullptr;
        const vpx_image_t* image = vpx_codec_get_frame(&decoder_, &next);
        REQUIRE(image != nullptr);
        std::vector<double>& shown = pictures.emplace_back();
        for (unsigned y = 0; y < image->d_h; ++y) {
            for (unsigned x = 0; x < image->d_w; ++x) {
                std::ranges::copy(color_of(*image, x, y), std::back_inserter(shown));
            }
        }
        return status;
    }

    double duration_ms = 0;
    std::string codec, title;
    std::uint64_t width = 0, height = 0;
    std::vector<std::int64_t> times_ms, cues_ms;
    std::vector<bool> keys;
    std::vector<std::vector<double>> pictures;  ///< Red, green, blue of each pixel.

  private:
    webm::Status begin(std::int64_t timecode, webm::Action* action) {
        times_ms.push_back(cluster_ms_ + timecode);
        *action = webm::Action::kRead;
        return webm::Status(webm::Status::kOkCompleted);
    }

    vpx_codec_ctx_t decoder_{};
    std::int64_t cluster_ms_ = 0;
};

/// Mean square of the differences.
double error_of(const std::vector<double>& shown, const Pixels& source) {
    REQUIRE(shown.size() == 3 * source.size());
    double sum = 0;
    for (std::size_t at = 0; at < shown.size(); ++at) {
        const double difference = shown[at] - (source[at / 3] >> (8 * (at % 3)) & 0xffU);
        sum += difference * difference;
    }
    return sum / static_cast<double>(shown.size());
}

void make(const fs::path& path, const FilmForm& form, int count) {
    Film film(path, form);
    for (int number = 0; number < count; ++number) {
        film.add(picture(form.width, form.height, number));
    }
    film.keep();
}

std::string bytes_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TEST_CASE("a film has its pictures in order, each at its time") {
    const Folder folder;
    constexpr int count = 130;
    const FilmForm form{160, 90, 30, "a scan", "seen from all sides"};
    make(folder.path / "film.webm", form, count);
    const Played played(folder.path / "film.webm");
    CHECK(played.codec == "V_VP8");
    CHECK(played.title == "a scan");
    CHECK(played.width == 160);
    CHECK(played.height == 90);
    CHECK(std::lround(played.duration_ms) == std::lround(1000.0 * count / 30));
    REQUIRE(played.pictures.size() == count);
    for (int number = 0; number < count; ++number) {
        const auto at = static_cast<std::size_t>(number);
        CAPTURE(number);
        CHECK(played.times_ms[at] == std::lround(1000.0 * number / 30));
        const double own = error_of(played.pictures[at], picture(160, 90, number));
        CHECK(own < 20);    // A PSNR of 35 dB.
        if (number < 18) {  // The disk leaves the picture then.
            CHECK(own < error_of(played.pictures[at], picture(160, 90, number + 1)));
        }
    }
}

TEST_CASE("players find a place at least every two seconds") {
    const Folder folder;
    make(folder.path / "film.webm", {64, 48, 10, "", ""}, 65);
    const Played played(folder.path / "film.webm");
    CHECK(played.keys.front());
    CHECK(played.cues_ms.front() == 0);
    std::int64_t last = 0;
    for (const std::int64_t cue : played.cues_ms) {
        CHECK(cue - last <= 2000);
        last = cue;
    }
    CHECK(6500 - last <= 2000);
}

TEST_CASE("films may have odd sizes, and one picture") {
    const Folder folder;
    for (const auto& [width, height] : {std::pair{33, 17}, {1, 1}, {130, 3}}) {
        const fs::path path = folder.path / "film.webm";
        make(path, {width, height, 25, "", ""}, 1);
        const Played played(path);
        REQUIRE(played.pictures.size() == 1);
        CHECK(error_of(played.pictures.front(), picture(width, height, 0)) < 60);
        CHECK(std::lround(played.duration_ms) == 40);
    }
}

TEST_CASE("the same pictures give the same bytes") {
    const Folder folder;
    const FilmForm form{96, 64, 25, "title", "comment"};
    make(folder.path / "a.webm", form, 12);
    make(folder.path / "b.webm", form, 12);
    CHECK(bytes_of(folder.path / "a.webm") == bytes_of(folder.path / "b.webm"));
    make(folder.path / "b.webm", form, 13);
    CHECK(bytes_of(folder.path / "a.webm") != bytes_of(folder.path / "b.webm"));
}

TEST_CASE("a film that is not kept leaves no file, and the former one stays") {
    const Folder folder;
    const auto begin = [&](const char* name) {
        Film film(folder.path / name, {64, 48, 25, "", ""});
        film.add(picture(64, 48, 0));
    };
    begin("film.webm");
    CHECK(folder.names().empty());
    make(folder.path / "film.webm", {64, 48, 25, "", ""}, 3);
    const std::string before = bytes_of(folder.path / "film.webm");
    begin("film.webm");
    CHECK(folder.names() == std::vector<std::string>{"film.webm"});
    CHECK(bytes_of(folder.path / "film.webm") == before);
}

TEST_CASE("a film that cannot be written says where and why") {
    const Folder folder;
    CHECK_THROWS_WITH_AS(Film(folder.path / "none" / "film.webm", {64, 48, 25, "", ""}),
                         doctest::Contains("none does not exist"), RequestError);
    // A device that is always full.
    fs::create_symlink("/dev/full", folder.path / "full.webm");
    CHECK_THROWS_WITH_AS(make(folder.path / "full.webm", {64, 48, 25, "", ""}, 2),
                         doctest::Contains("full.webm"), RequestError);
}

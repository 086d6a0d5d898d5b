#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <deque>

#include "host/serve/encoding/link_rate.hpp"

namespace pxpl5::host::serve {
namespace {

/// A pipe of so many bytes a second, behind which acknowledgements take the latency to come back.
struct Pipe {
    double bytes_per_s = 1e6;
    double latency_ms = 10;
    double free_ms = 0;

    double acknowledged_ms(double bytes, double sent_ms) {
        free_ms = std::max(free_ms, sent_ms) + bytes / bytes_per_s * 1000;
        return free_ms + latency_ms;
    }
};

struct Outcome {
    double bytes_per_s = 0, frames_per_s = 0;
    JpegQuality quality;
    double scale = 0;
    bool is_video = false;
    std::size_t bytes = 0;  ///< Size of the last frame.
};

/// A viewer, and what moves on its screen.
struct Screen {
    bool takes_video = false;
    double display_ms = 0;            ///< Time to decode and display a frame.
    double video_bytes_needed = 1e9;  ///< At the best quality of the encoder.
    double depth_bytes_per_pixel = 0;
};

constexpr std::size_t full_pixels = 512 * 512;

/// Bytes of a JPEG: of a picture that grows faster with quality than LinkRate takes for usual.
double jpeg_bytes(JpegQuality quality, double pixels) {
    constexpr std::array<double, 5> growth{1, 1.25, 1.5, 2.1, 3.2};
    constexpr double growth_of_color = 1.6;
    return 0.06 * pixels * growth[static_cast<std::size_t>((quality.quality - 50) / 10)] *
           (quality.full_color ? growth_of_color : 1);
}

/// Sends frames for 20 s, as many as two acknowledgements allow and at most 60 a second.
Outcome drive(LinkRate& rate, Pipe& pipe, double begin_ms, const Screen& screen = {}) {
    struct Acknowledgement {
        std::uint32_t number;
        double at_ms;
        double since_arrival_ms;
    };
    static std::uint32_t number = 0;
    std::deque<Acknowledgement> coming;
    Outcome outcome;
    double next_ms = begin_ms;
    int shown_late = 0;
    double displayed_ms = 0;
    constexpr double span_ms = 20'000;
    for (double now = begin_ms; now < begin_ms + span_ms; now += 0.25) {
        while (!coming.empty() && coming.front().at_ms <= now) {
            rate.shown(coming.front().number, coming.front().at_ms,
                       coming.front().since_arrival_ms);
            if (now > begin_ms + span_ms / 2) {
                ++shown_late;
            }
            coming.pop_front();
        }
        if (now < next_ms || rate.unacknowledged() >= 2) {
            continue;
        }
        next_ms = now + 1000.0 / 60;
        const double scale = rate.scale(full_pixels);
        const auto pixels = static_cast<std::size_t>(full_pixels * scale * scale);
        outcome.is_video = rate.uses_video(full_pixels, screen.takes_video);
        if (outcome.is_video) {
            const double most = screen.video_bytes_needed * scale * scale;
            outcome.bytes = std::min(rate.video_bytes(), static_cast<std::size_t>(most));
            rate.encoded_depths(pixels, static_cast<std::size_t>(screen.depth_bytes_per_pixel *
                                                                 static_cast<double>(pixels)));
            rate.sent(++number, outcome.bytes, now, PictureKind::vp8);
        } else {
            outcome.quality = rate.quality(pixels);
            outcome.bytes =
                static_cast<std::size_t>(jpeg_bytes(outcome.quality, static_cast<double>(pixels)));
            rate.encoded(outcome.quality, pixels, outcome.bytes);
            rate.sent(++number, outcome.bytes, now);
        }
        const double arrived_ms = pipe.acknowledged_ms(static_cast<double>(outcome.bytes), now);
        displayed_ms = std::max(displayed_ms, arrived_ms) + screen.display_ms;
        coming.push_back({number, displayed_ms, displayed_ms - arrived_ms});
        outcome.scale = scale;
    }
    while (!coming.empty()) {
        rate.shown(coming.front().number, coming.front().at_ms);
        coming.pop_front();
    }
    outcome.bytes_per_s = rate.bytes_per_s();
    outcome.frames_per_s = shown_late / (span_ms / 2 / 1000);
    return outcome;
}

Outcome drive(double bytes_per_s, double latency_ms, const Screen& screen = {}) {
    LinkRate rate;
    rate.pinged(latency_ms);
    Pipe pipe{bytes_per_s, latency_ms, 0};
    return drive(rate, pipe, 1000, screen);
}

/// Three resting pictures, one after the other.
void rest(LinkRate& rate, Pipe& pipe, double begin_ms) {
    static std::uint32_t number = 1'000'000;
    constexpr std::size_t png_bytes = 150'000;
    double now = begin_ms;
    for (int i = 0; i < 3; ++i) {
        rate.sent(++number, png_bytes, now, PictureKind::png);
        now = pipe.acknowledged_ms(png_bytes, now);
        rate.shown(number, now);
    }
}

}  // namespace

TEST_CASE("the rate of a pipe is measured to a tenth, whatever its latency") {
    for (const double bytes_per_s : {2e5, 1e6, 5e6}) {
        for (const double latency_ms : {0.5, 20.0, 200.0}) {
            CAPTURE(bytes_per_s);
            CAPTURE(latency_ms);
            CHECK(drive(bytes_per_s, latency_ms).bytes_per_s ==
                  doctest::Approx(bytes_per_s).epsilon(0.1));
        }
    }
}

TEST_CASE("a fast link gets the best quality at full size, even if it is far away") {
    for (const double latency_ms : {0.2, 20.0, 200.0}) {
        const Outcome outcome = drive(2e7, latency_ms);
        CHECK(outcome.quality == best_quality);
        CHECK(outcome.scale == 1);
    }
}

TEST_CASE("a slow link gets worse pictures, then smaller ones, 25 a second while that suffices") {
    const Outcome middling = drive(6e5, 10);
    CHECK(middling.quality < JpegQuality{90, false});
    CHECK(middling.scale == 1);
    CHECK(middling.frames_per_s >= 24);
    const Outcome slow = drive(2e5, 10);
    CHECK(slow.scale == 0.5);
    CHECK(slow.frames_per_s >= 24);
}

TEST_CASE("the color of each pixel is sent only if the link has room for it at best quality") {
    // A frame of quality 90 has 50 kB, one with all colors 81 kB: 25 frames need 1.3 and 2 MB/s.
    const Outcome tight = drive(1.7e6, 10);
    CHECK(tight.quality == JpegQuality{90, false});
    CHECK(tight.scale == 1);
    const Outcome roomy = drive(3e6, 10);
    CHECK(roomy.quality == JpegQuality{90, true});
    CHECK(roomy.frames_per_s >= 24);
}

TEST_CASE("a slow link gets video if the viewer takes it, and so pictures of full size") {
    const Outcome jpeg = drive(2e5, 10);
    CHECK_FALSE(jpeg.is_video);
    CHECK(jpeg.scale == 0.5);
    const Outcome video = drive(2e5, 10, {.takes_video = true});
    CHECK(video.is_video);
    CHECK(video.scale == 1);
    CHECK(video.frames_per_s >= 24);
    CHECK(drive(5e4, 10, {.takes_video = true}).scale == 0.5);
}

TEST_CASE("a link with room for good JPEG gets no video, also if the browser is slow") {
    for (const double display_ms : {0.0, 15.0, 60.0}) {
        CAPTURE(display_ms);
        const Outcome outcome = drive(4e6, 10, {.takes_video = true, .display_ms = display_ms});
        CHECK_FALSE(outcome.is_video);
        CHECK((display_ms < 60 || outcome.quality < JpegQuality{90, false}));
    }
}

TEST_CASE("video frames that are displayed late do not become smaller, as the link is no slower") {
    for (const double display_ms : {0.0, 16.0, 60.0}) {
        for (const double needed : {2'000.0, 10'000.0, 1e9}) {
            CAPTURE(display_ms);
            CAPTURE(needed);
            const Screen screen{
                .takes_video = true, .display_ms = display_ms, .video_bytes_needed = needed};
            const Outcome outcome = drive(5e5, 10, screen);
            CHECK(outcome.is_video);
            CHECK(outcome.scale == 1);
            CHECK((display_ms > 40 || outcome.frames_per_s >= 24));
            CHECK(static_cast<double>(outcome.bytes) >= std::min(needed, 14'000.0));
        }
    }
}

TEST_CASE("a link that slows down while it carries video gets smaller frames, then larger again") {
    LinkRate rate;
    rate.pinged(5);
    Pipe pipe{5e5, 5, 0};
    const Screen screen{.takes_video = true, .display_ms = 5};
    const std::size_t before = drive(rate, pipe, 0, screen).bytes;
    pipe.bytes_per_s = 2e5;
    CHECK(drive(rate, pipe, 30'000, screen).bytes < before / 2);
    pipe.bytes_per_s = 5e5;
    CHECK(drive(rate, pipe, 60'000, screen).bytes > before * 3 / 4);
}

TEST_CASE("video ends after a resting picture that shows a faster link, not before") {
    LinkRate rate;
    rate.pinged(5);
    Pipe pipe{3e5, 5, 0};
    const Screen screen{.takes_video = true, .display_ms = 10, .video_bytes_needed = 12'000};
    CHECK(drive(rate, pipe, 0, screen).is_video);
    rest(rate, pipe, 30'000);
    CHECK(drive(rate, pipe, 40'000, screen).is_video);
    pipe.bytes_per_s = 2e7;
    CHECK(drive(rate, pipe, 70'000, screen).is_video);
    rest(rate, pipe, 100'000);
    CHECK_FALSE(drive(rate, pipe, 110'000, screen).is_video);
}

TEST_CASE("a link that slows down and recovers is followed both ways") {
    LinkRate rate;
    rate.pinged(5);
    Pipe pipe{1e7, 5, 0};
    CHECK(drive(rate, pipe, 0).quality == best_quality);
    pipe.bytes_per_s = 2e5;
    CHECK(drive(rate, pipe, 30'000).scale == 0.5);
    pipe.bytes_per_s = 1e7;
    const Outcome again = drive(rate, pipe, 60'000);
    CHECK(again.quality == best_quality);
    CHECK(again.scale == 1);
}

TEST_CASE("a tab that was hidden for minutes has soon its old quality again") {
    LinkRate rate;
    rate.pinged(5);
    Pipe pipe{1e7, 5, 0};
    CHECK(drive(rate, pipe, 0).quality == best_quality);
    rate.sent(1'000'000, 20'000, 30'000);
    rate.shown(1'000'000, 630'000);
    constexpr std::uint32_t frames = 40;  // About 2 s of them.
    for (std::uint32_t i = 1; i <= frames; ++i) {
        const double sent_ms = 630'000 + 40.0 * i;
        rate.sent(1'000'000 + i, 20'000, sent_ms);
        rate.shown(1'000'000 + i, sent_ms + 7);
    }
    CHECK(rate.bytes_per_s() == doctest::Approx(1e7).epsilon(0.1));
}

TEST_CASE("an acknowledgement of a later frame is one of all before it") {
    LinkRate rate;
    rate.sent(1, 1000, 0);
    rate.sent(2, 1000, 0);
    CHECK(rate.unacknowledged() == 2);
    rate.shown(2, 10);
    CHECK(rate.unacknowledged() == 0);
    CHECK(rate.bytes_per_s() == doctest::Approx(200'000));
}

TEST_CASE("acknowledgements of what was never sent, or twice, change nothing") {
    LinkRate rate;
    rate.sent(7, 1000, 0);
    rate.shown(8, 5);
    rate.shown(6, 5);
    rate.shown(0, 5);
    CHECK(rate.unacknowledged() == 1);
    CHECK(rate.bytes_per_s() == 0);
    rate.shown(7, 10);
    rate.shown(7, 20);
    CHECK(rate.bytes_per_s() == doctest::Approx(100'000));
}

TEST_CASE("depths that fill a slow link make video frames smaller") {
    Screen crowded;
    crowded.takes_video = true;
    crowded.depth_bytes_per_pixel = 0.05;
    CHECK(drive(2e5, 10, crowded).scale == 0.5);
}

TEST_CASE("a link is stalled when a frame has been under way for 2 s, whatever came before") {
    LinkRate rate;
    CHECK_FALSE(rate.is_stalled(1e9));
    rate.sent(1, 1000, 0);
    CHECK_FALSE(rate.is_stalled(1999));
    CHECK(rate.is_stalled(2001));
    rate.sent(2, 1000, 2000);
    rate.shown(1, 2500);
    CHECK_FALSE(rate.is_stalled(4499));
    CHECK(rate.is_stalled(4501));
    rate.shown(2, 5000);
    CHECK_FALSE(rate.is_stalled(1e9));
}

}  // namespace pxpl5::host::serve

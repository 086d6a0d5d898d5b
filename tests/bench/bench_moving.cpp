// Measures the encoding of moving pictures: a surface that turns, as JPEG and as video.
#include <benchmark/benchmark.h>

#include <functional>

#include "host/serve/encoding/encode.hpp"
#include "host/serve/video/video_encoder.hpp"
#include "tests/bench/parts.hpp"
#include "tests/host/serve/moving_pictures.hpp"

using namespace pxpl5;
using bench::Held;
using bus::Body;
namespace decoding = host::serve::test;
using decoding::Pixels;

namespace {

constexpr int picture_count = 40;
constexpr std::size_t plenty = 1'000'000;  // Bytes of a frame: the best quality of the encoder.

struct Turning {
    int width = 0, height = 0;
    std::vector<Pixels> pictures;
};

/// The pelvis in several views, one after the other.
const Turning& turning(host::Size size) {
    static std::map<int, Turning> known;
    Turning& turning = known[size.width];
    if (!turning.pictures.empty()) {
        return turning;
    }
    turning.width = size.width;
    turning.height = size.height;
    bench::Parts parts("phantom:pelvis", size);
    for (std::uint32_t number = 1; number <= picture_count; ++number) {
        parts.draw(number);
        const Held begin(parts.gp_wire.first(Body::BeginFrame)),
            programs(parts.gp_wire.first(Body::RegionPrograms));
        parts.renderer_wire.sent.clear();
        parts.renderer.receive(begin.message(bench::renderer_id), parts.renderer_wire);
        parts.renderer.receive(programs.message(bench::renderer_id), parts.renderer_wire);
        bench::Parts::work(parts.renderer, parts.renderer_wire);
        const Held pixels(parts.renderer_wire.first(Body::RegionPixels));
        parts.frame_buffer_wire.sent.clear();
        parts.frame_buffer.receive(begin.message(bench::frame_buffer_id), parts.frame_buffer_wire);
        parts.frame_buffer.receive(pixels.message(bench::frame_buffer_id), parts.frame_buffer_wire);
        bench::Parts::work(parts.frame_buffer, parts.frame_buffer_wire);
        const auto& done = parts.frame_buffer_wire.first(Body::FrameDone);
        const auto& words =
            *bus::schema::GetMessage(done.bytes().data())->body_as_FrameDone()->pixels();
        turning.pictures.emplace_back(words.begin(), words.end());
    }
    return turning;
}

/// Encodes one picture per iteration. Sets the mean of bytes and PSNR of all pictures.
void measure_turning(benchmark::State& state, const Turning& turning,
                     const std::function<std::string(const Pixels&)>& encode,
                     const std::function<Pixels(const std::string&)>& decode) {
    double bytes = 0, psnr = 0;
    for (const Pixels& picture : turning.pictures) {
        const std::string encoded = encode(picture);
        bytes += static_cast<double>(encoded.size()) / picture_count;
        psnr += decoding::psnr(picture, decode(encoded)) / picture_count;
    }
    std::size_t next = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(encode(turning.pictures[next]));
        next = (next + 1) % turning.pictures.size();
    }
    state.counters["bytes"] = bytes;
    state.counters["psnr_db"] = psnr;
}

host::Size picture_size(const benchmark::State& state) {
    return {static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
}

template <int Quality, bool FullColor>
void moving_jpeg(benchmark::State& state) {
    const Turning& seen = turning(picture_size(state));
    measure_turning(
        state, seen,
        [&](const Pixels& picture) {
            return host::serve::jpeg_of(seen.width, seen.height, picture, {Quality, FullColor});
        },
        [&](const std::string& bytes) {
            return decoding::decoded_jpeg(bytes, seen.width, seen.height);
        });
}

/// Mean bytes of JPEGs with at least this PSNR, by the least quality that has it.
double jpeg_bytes_at(const Turning& seen, double psnr_db) {
    for (int quality = 30; quality <= 100; ++quality) {
        double bytes = 0, psnr = 0;
        constexpr std::size_t step = 8;
        int count = 0;
        for (std::size_t i = 0; i < seen.pictures.size(); i += step, ++count) {
            const Pixels& picture = seen.pictures[i];
            const std::string jpeg =
                host::serve::jpeg_of(seen.width, seen.height, picture, {quality, false});
            bytes += static_cast<double>(jpeg.size());
            psnr += decoding::psnr(picture, decoding::decoded_jpeg(jpeg, seen.width, seen.height));
        }
        if (psnr / count >= psnr_db) {
            return bytes / count;
        }
    }
    return 0;
}

void moving_video(benchmark::State& state) {
    const Turning& seen = turning(picture_size(state));
    host::serve::VideoEncoder encoder;
    decoding::VideoDecoder decoder;
    measure_turning(
        state, seen,
        [&](const Pixels& picture) {
            return encoder.encode(seen.width, seen.height, picture, plenty).bytes;
        },
        [&](const std::string& bytes) { return decoder.decode(bytes); });
    state.counters["jpeg_bytes"] = jpeg_bytes_at(seen, state.counters["psnr_db"]);
}

void turning_sizes(benchmark::internal::Benchmark* bench) {
    bench->ArgNames({"width", "height"})
        ->Args({512, 512})
        ->Args({1280, 1024})
        ->Unit(benchmark::kMillisecond);
}

BENCHMARK(moving_jpeg<50, false>)->Apply(turning_sizes);
BENCHMARK(moving_jpeg<90, false>)->Apply(turning_sizes);
BENCHMARK(moving_jpeg<90, true>)->Apply(turning_sizes);
BENCHMARK(moving_video)->Apply(turning_sizes);

}  // namespace

// A server without a machine, for test_server*.py: does what viewers say, until its input ends.
//
// It prints its two addresses and then each event. A viewer's text `{"echo":x}` comes back to it;
// `{"frame":[width,height,revision,rests,depths]}` shows a frame whose colors follow from the
// revision, and with depths if the last word is true. Another `true` makes it a frame of two
// layers; a pose and a viewer instead make it a pair for that viewer, who wears a headset after
// `{"wear":[viewer,pixels]}`. `"scale":x` beside a frame says how large it is compared with that at
// rest, and `"fixed":true` that it must keep its size;
// `{"texts":[count,bytes]}` sends so many texts; `{"binary":bytes}` one binary message;
// `{"say":x}` goes to all; `{"wants":0}` reports if a frame is wanted.
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/serve/encoding/encode.hpp"
#include "host/serve/server/server.hpp"

namespace {

using namespace pxpl5::host;
using Json = nlohmann::json;

serve::Shown frame_of(const Json& words) {
    serve::Shown frame;
    frame.width = words[0];
    frame.height = words[1];
    frame.revision = words[2];
    frame.rests = words[3];
    frame.digest = frame.rests ? frame.revision : 0;
    if (words.size() > 6) {
        frame.views = 2;
        frame.pose = words[5];
        frame.viewer = words[6];
    } else if (words.size() > 5 && words[5]) {
        frame.layers = 2;
        frame.opacity = 6;
    }
    std::vector<std::uint32_t> pixels(
        static_cast<std::size_t>(frame.pictures() * frame.width * frame.height));
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        pixels[i] =
            0xff000000U | static_cast<std::uint32_t>(i * 2654435761U + frame.revision) >> 8U;
    }
    if (words.size() > 4 && words[4]) {
        constexpr std::uint32_t middle = 0x800000'01U;  // Of surface 1.
        frame.depths = std::vector<std::uint32_t>(pixels.size(), middle);
    }
    frame.pixels = std::move(pixels);
    if (frame.layers > 1) {
        frame.as_one = [pixels = frame.pixels, width = frame.width, height = frame.height,
                        opacity = frame.opacity] {
            return serve::OnePicture{width, height, serve::blended(pixels, 1, opacity)};
        };
    }
    return frame;
}

void obey(serve::Server& server, const serve::Said& said) {
    const Json words = Json::parse(said.text, nullptr, false);
    if (words.contains("frame")) {
        serve::Shown frame = frame_of(words["frame"]);
        frame.scale = words.value("scale", 1.0);
        frame.fixed_size = words.value("fixed", false);
        server.show(std::move(frame));
    }
    if (words.contains("wear")) {
        server.wear(words["wear"][0], words["wear"][1]);
    }
    if (words.contains("echo")) {
        server.send(said.viewer, words.dump());
    }
    if (words.contains("opened")) {
        server.opened(words["opened"].get<std::string>());
    }
    if (words.contains("say")) {
        server.broadcast(words.dump());
    }
    if (words.contains("wants")) {
        server.send(said.viewer, Json{{"wants", server.wants_frame()},
                                      {"pair", server.wants_pair()},
                                      {"scale", server.advice().scale},
                                      {"pair_scale", server.advice().pair_scale},
                                      {"depths", server.advice().wants_depths}}
                                     .dump());
    }
    if (words.contains("binary")) {
        server.send_binary(said.viewer, std::string(words["binary"].get<std::size_t>(), 'b'));
    }
    if (words.contains("texts")) {
        for (int i = 0; i < words["texts"][0]; ++i) {
            server.send(said.viewer, std::string(words["texts"][1].get<std::size_t>(), 't'));
        }
    }
}

void tell(serve::Server& server, const serve::Event& event) {
    if (const auto* joined = std::get_if<serve::Joined>(&event)) {
        const bool drives = joined->role == serve::Role::driver;
        fmt::print("joined {} {}\n", joined->viewer, drives ? "driver" : "watcher");
        server.send(joined->viewer, Json{{"hello", joined->viewer}}.dump());
    } else if (const auto* left = std::get_if<serve::Left>(&event)) {
        fmt::print("left {}\n", left->viewer);
    } else {
        obey(server, std::get<serve::Said>(event));
    }
    std::fflush(stdout);
}

serve::ServerOptions options_of(int count, char** words) {
    serve::ServerOptions options;
    for (int i = 1; i + 1 < count; i += 2) {
        const std::string key = words[i], value = words[i + 1];
        if (key == "bind") {
            options.bind = value;
        }
        if (key == "port") {
            options.port = std::stoi(value);
        }
        if (key == "insecure") {
            options.insecure = value == "1";
        }
        if (key == "cert") {
            options.tls_cert = value;
        }
        if (key == "key") {
            options.tls_key = value;
        }
        if (key == "allow-host") {
            options.allowed_hosts.push_back(value);
        }
        if (key == "page") {
            options.page = value;
        }
        if (key == "uploads") {
            options.uploads = value;
        }
        if (key == "downloads") {
            options.downloads = value;
        }
    }
    return options;
}

}  // namespace

int main(int count, char** words) {
    try {
        serve::Server server(options_of(count, words));
        fmt::print("{}\n{}\n", server.url(), server.watch_url());
        std::fflush(stdout);
        std::array<pollfd, 2> wait{{{server.event_fd(), POLLIN, 0}, {STDIN_FILENO, POLLIN, 0}}};
        while (poll(wait.data(), wait.size(), -1) > 0 && wait[1].revents == 0) {
            for (const serve::Event& event : server.take()) {
                tell(server, event);
            }
        }
        return 0;
    } catch (const RequestError& error) {
        fmt::print(stderr, "{}\n", error.what());
        return static_cast<int>(error.code);
    }
}

// A viewer's words: messages over the WebSocket, paths, headers of requests, names of uploads.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include "host/base/error.hpp"
#include "host/serve/director/viewer_message.hpp"
#include "host/serve/server/routes.hpp"
#include "host/serve/server/server_access.hpp"
#include "host/serve/server/server_uploads.hpp"
#include "host/serve/server/server_viewer.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/scratch.hpp"

namespace pxpl5::fuzz {

namespace {

using namespace host::serve;
namespace fs = std::filesystem;

/// Only matrices of an eye that a machine can draw for are accepted.
void require_drawable(const HeadsetEyes& eyes) {
    require(eyes.pose > 0 && std::min(eyes.size.width, eyes.size.height) >= min_eye_px,
            "eyes without a pose or a size");
    for (const host::CameraMatrices& eye : {eyes.eyes.left, eyes.eyes.right}) {
        const glm::dmat4 change = glm::inverse(eye.patient_to_eye) * eye.patient_to_eye;
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 4; ++row) {
                require(std::isfinite(eye.projection[column][row]), "an infinite projection");
                require(std::abs(change[column][row] - (column == row ? 1 : 0)) < 1e-3,
                        "patient_to_eye without an inverse");
            }
        }
        require((eye.projection * glm::dvec4(0, 0, -1, 1)).w > 0, "eyes that look backward");
    }
}

bool accepts_message(const std::string& text) {
    Viewer viewer(1, Role::driver);
    const std::optional<std::string> heard = viewer.hear(text, true, 1);
    require(!heard || *heard == text, "a text that changes on its way");
    shown_frame(text);
    wanted_depths(text);
    wanted_video(text);
    try {
        const ViewerMessage message = read_viewer_message(text);
        const int meanings = int{message.line.has_value()} + int{message.ask.has_value()} +
                             int{message.panel.has_value()} + int{message.cancels} +
                             int{message.is_ping} + int{message.is_of_headset};
        require(meanings == 1, "a message of several meanings");
        require(message.id || !(message.ask || message.is_ping), "a question without a number");
        if (message.eyes) {
            require_drawable(*message.eyes);
        }
        return true;
    } catch (const host::RequestError& error) {
        require(error.code == host::ExitCode::usage &&
                    std::string(error.what()).starts_with("message: "),
                error.what());
        return false;
    }
}

/// A name leads to a file below the folder, which is not hidden.
bool accepts_name(const std::string& name) {
    const fs::path path = cleaned_name(name);
    require(!path.is_absolute(), "an absolute path: " + path.string());
    for (const fs::path& part : path) {
        const std::string text = part.string();
        require(!text.empty() && text.front() != '.', "a hidden part: " + text);
        require(std::ranges::none_of(text, [](unsigned char c) { return c < ' ' || c == 0x7f; }),
                "a control character in a name");
    }
    return !path.empty();
}

/// A path names a file of the page, or one directly in the folder of downloads.
bool accepts_path(const std::string& text) {
    static const Scratch scratch;
    static const Routes routes([] {
        scratch.write("picture.png", "picture");
        RouteFolders folders = built_in_folders();
        folders.downloads = scratch.path();
        return folders;
    }());
    constexpr int port = 80;  // A portal may leave a prefix that ends with it.
    const Route route = routes.find(text, port);
    if (route.kind == RouteKind::file) {
        const fs::path path = route.file.path;
        const RouteFolders folders = built_in_folders();
        const auto is_below = [&path](const fs::path& folder) {
            return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first ==
                   folder.end();
        };
        require(is_below(folders.page) || is_below(folders.bundle) ||
                    path.parent_path() == scratch.path(),
                "a file elsewhere: " + path.string());
        require(path.lexically_normal() == path, "a path that leads up: " + path.string());
    }
    return route.kind != RouteKind::none;
}

/// Only a request that shows a secret, to a known name, is allowed.
bool accepts_request(Bytes bytes) {
    const AccessRules rules{"driver-token",
                            "watcher-token",
                            "driver-session",
                            "watcher-session",
                            "pxpl5_1",
                            {"localhost"},
                            false};
    constexpr char end = '\n';
    Request request;
    request.method = bytes.text_before(end);
    request.path = bytes.text_before(end);
    request.host = bytes.text_before(end);
    request.origin = bytes.text_before(end);
    request.cookie = bytes.text_before(end);
    while (!bytes.empty()) {
        const std::string key = bytes.text_before('=');
        request.query[key] = bytes.text_before(end);
    }
    const Verdict verdict = judge(rules, request);
    require((verdict.status == 200) == verdict.reason.empty(), "a reason for each refusal");
    if (verdict.status != 200) {
        require(verdict.status == 400 || verdict.status == 403, "the status of a refusal");
        return false;
    }
    bool shows = false;
    for (const auto& [key, value] : request.query) {
        shows = shows || value == rules.driver_token || value == rules.watcher_token;
    }
    shows = shows || request.cookie.find(rules.driver_session) != std::string::npos ||
            request.cookie.find(rules.watcher_session) != std::string::npos;
    require(shows, "a request without a secret is allowed");
    std::string name = request.host.substr(0, request.host.find(':'));
    std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
    require(name == "localhost", "a request to another name is allowed: " + request.host);
    return true;
}

/// Files that come in one body. All lie below the folder of uploads.
bool accepts_upload(Bytes bytes) {
    static const Scratch scratch;
    scratch.clear();
    Uploads uploads(scratch.path());
    try {
        UploadingFiles files(uploads, "batch");
        while (!bytes.empty()) {
            std::array<char, 16> part{};
            const std::size_t count = 1 + bytes.take<std::uint8_t>() % part.size();
            std::size_t size = 0;
            while (size < count && !bytes.empty()) {
                part.at(size++) = bytes.take<char>();
            }
            files.append({part.data(), size});
        }
        files.finish();
        const UploadedBatch done = uploads.done("batch");
        const auto relative = fs::weakly_canonical(done.path).lexically_relative(scratch.path());
        require(!relative.empty() && *relative.begin() != "..", "an upload elsewhere");
        return true;
    } catch (const UploadError& error) {
        require(error.status >= 400 && !error.text.empty(), "an upload's error without a text");
        return false;
    }
}

}  // namespace

/// Input: a letter, and what it says.
bool accepts(Input input) {
    Bytes bytes(input);
    switch (bytes.take<char>()) {
        case 'm':
            return accepts_message(bytes.text());
        case 'n':
            return accepts_name(bytes.text());
        case 'p':
            return accepts_path(bytes.text());
        case 'u':
            return accepts_upload(bytes);
        default:
            return accepts_request(bytes);
    }
}

}  // namespace pxpl5::fuzz

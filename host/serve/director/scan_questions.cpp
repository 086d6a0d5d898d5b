#include "host/serve/director/scan_questions.hpp"

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/json_depth.hpp"
#include "host/base/kernel/run_program.hpp"
#include "host/base/kernel/signals_blocked.hpp"
#include "host/base/reply.hpp"
#include "host/serve/director/inspector.hpp"

namespace pxpl5::host::serve {

namespace {

using Json = nlohmann::json;

constexpr std::size_t max_answer_bytes = std::size_t{1} << 20;  ///< The sandbox limits files alike.
constexpr int max_thumbnail_side = 256;

std::string dump(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// A text of pxpl5-io as JSON. Discarded if it is none, or if it is nested more deeply than any
/// answer is: dump() and copies recurse, and the process may be in the hands of a file.
Json parse_answer(const std::string& text) {
    constexpr int max_levels = 16;
    return parse_json(text, max_levels).json;
}

/// The words of pxpl5-io for a question; none if the message is another one. No word from outside
/// can be taken for an option.
std::vector<std::string> words_of(const Json& ask, const ScanQuestions::OpenScan& open) {
    const Json name = ask.is_object() && ask.contains("ask") ? ask["ask"] : Json();
    if (name == "attributes") {
        if (!open.source.starts_with('/')) {
            refuse_command("ask attributes: no file is open that could have DICOM attributes");
        }
        return {"--attributes", open.source, "series=" + open.series};
    }
    if (name != "series") {
        return {};
    }
    const Json given = ask.contains("path") ? ask["path"] : Json();
    const std::string path = given.is_string() ? given.get<std::string>() : "";
    if (!path.starts_with('/') || path.find('\0') != std::string::npos) {
        constexpr std::size_t most_chars = 200;
        refuse_command(fmt::format("ask series: 'path' is {}; it must be a path from /",
                                   dump(given).substr(0, most_chars)));
    }
    return {"--series", path};
}

/// Why the process has ended before the end of its answer; empty if it has not.
std::string reason_of(const std::string& path, const ProgramEnd& end) {
    if (!end.is_in_time) {
        return fmt::format(
            "{}: reading took longer than {} s; open a smaller folder, or one of its files", path,
            scan_question_ms / 1000);
    }
    const std::string errors = end.errors.substr(0, end.errors.find('\n'));
    return end.code == 0    ? ""
           : errors.empty() ? fmt::format("{}: pxpl5-io ended with exit code {}", path, end.code)
                            : errors;
}

int digit_of(char c) {
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/// The bytes of a text of hexadecimal digits; empty if it is none of `count` bytes.
std::string bytes_of_hex(const std::string& hex, std::size_t count) {
    std::string bytes;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
        const int high = digit_of(hex[i]), low = digit_of(hex[i + 1]);
        if (high < 0 || low < 0) {
            return "";
        }
        bytes += static_cast<char>(16 * high + low);
    }
    return bytes.size() == count && hex.size() == 2 * count ? bytes : "";
}

/// Adds the pixels of a thumbnail, and their place to its row. Leaves out what is no thumbnail.
void add_thumbnail(const Json& line, Json& rows, std::string& pixels) {
    const auto whole = [&line](const char* key) {
        return line.contains(key) && line[key].is_number_unsigned() ? line[key].get<std::uint64_t>()
                                                                    : UINT64_MAX;
    };
    const std::uint64_t row = whole("thumbnail"), width = whole("width"), height = whole("height");
    if (row >= rows.size() || width - 1 >= max_thumbnail_side || height - 1 >= max_thumbnail_side ||
        !line.contains("pixels") || !line["pixels"].is_string()) {
        return;
    }
    const std::string bytes =
        bytes_of_hex(line["pixels"].get<std::string>(), static_cast<std::size_t>(width * height));
    if (!bytes.empty()) {
        rows[row]["thumbnail"] = {{"first", pixels.size()}, {"width", width}, {"height", height}};
        pixels += bytes;
    }
}

std::string message_of(std::uint32_t id, const std::vector<std::string>& question,
                       const ProgramEnd& end) {
    const std::string reason = reason_of(question[1], end);
    if (question[0] == "--series") {
        const SeriesAnswer series = read_series_lines(end.out, reason);
        Answer answer{series.json, {}};
        for (const char c : series.pixels) {
            answer.bytes.push_back(static_cast<std::byte>(c));
        }
        return answer_message(id, answer);
    }
    const Json attributes = parse_answer(end.out);
    if (!attributes.is_object()) {
        throw RequestError(
            ExitCode::bad_data,
            !reason.empty() ? reason : question[1] + ": pxpl5-io has listed no attributes");
    }
    return answer_message(id, {dump(attributes), {}});
}

}  // namespace

SeriesAnswer read_series_lines(const std::string& lines, const std::string& note) {
    std::istringstream stream(lines);
    std::string text;
    std::getline(stream, text);
    const Json list = parse_answer(text);
    if (!list.is_object() || !list.contains("series") || !list["series"].is_array()) {
        throw RequestError(ExitCode::bad_data,
                           note.empty() ? "pxpl5-io has listed no series" : note);
    }
    Json rows = Json::array();
    for (const Json& row : list["series"]) {
        if (row.is_object()) {
            rows.push_back(row);
        }
    }
    std::string pixels;
    while (std::getline(stream, text)) {
        const Json line = parse_answer(text);
        if (line.is_object() && line.contains("thumbnail")) {
            add_thumbnail(line, rows, pixels);
        }
    }
    return {dump({{"series", rows}, {"more", list.value("more", Json(0))}, {"note", note}}),
            pixels};
}

ScanQuestions::ScanQuestions(Parts parts)
    : parts_(std::move(parts)), stop_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (stop_fd_ < 0) {
        throw std::system_error(errno, std::generic_category(), "eventfd");
    }
}

ScanQuestions::~ScanQuestions() {
    stop();
    close(stop_fd_);
}

void ScanQuestions::stop() {
    if (thread_.joinable()) {
        (void)eventfd_write(stop_fd_, 1);
        thread_.join();
    }
    eventfd_t count = 0;
    (void)eventfd_read(stop_fd_, &count);
}

bool ScanQuestions::ask(std::uint32_t viewer, std::uint32_t id, std::string_view message,
                        const OpenScan& open) {
    const std::vector<std::string> question = words_of(Json::parse(message, nullptr, false), open);
    if (question.empty()) {
        return false;
    }
    parts_.check(question[1]);
    stop();
    const SignalsBlocked blocked;
    thread_ = std::thread([this, viewer, id, question] { answer(viewer, id, question); });
    return true;
}

void ScanQuestions::answer(std::uint32_t viewer, std::uint32_t id,
                           const std::vector<std::string>& question) {
    const auto refuse = [&](const Field& why) {
        parts_.send(viewer, json_text({{"re", std::int64_t{id}}, {"ok", false}, why}));
    };
    try {
        std::vector<std::string> words = parts_.words;
        words.insert(words.end(), question.begin(), question.end());
        const ProgramEnd end = run_program(words, "", scan_question_ms, stop_fd_, max_answer_bytes);
        eventfd_t count = 0;
        if (!end.is_in_time && eventfd_read(stop_fd_, &count) == 0) {
            refuse(
                {"error", "ask: a newer question about DICOM files has ended this one. Ask again"});
            return;
        }
        parts_.send_binary(viewer, message_of(id, question, end));
    } catch (const std::exception& error) {
        refuse({"error", std::string(error.what())});
    }
}

}  // namespace pxpl5::host::serve

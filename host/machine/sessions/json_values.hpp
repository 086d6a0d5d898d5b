// Values of a JSON file that may be missing or damaged.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace pxpl5::host {

/// Returns a discarded value if the file cannot be read, or is no regular file of up to 1 MiB.
inline nlohmann::json read_json(const std::filesystem::path& path) {
    constexpr off_t max_bytes = off_t{1} << 20;
    // O_NONBLOCK: a FIFO without a writer would block here for ever.
    const int file =
        ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    struct stat facts {};
    std::string text;
    if (file >= 0 && fstat(file, &facts) == 0 && S_ISREG(facts.st_mode) &&
        facts.st_size <= max_bytes) {
        text.resize(static_cast<std::size_t>(facts.st_size));
        const ssize_t got = ::read(file, text.data(), text.size());
        text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    }
    if (file >= 0) {
        ::close(file);
    }
    return nlohmann::json::parse(text, nullptr, false);
}

/// Returns an empty text if `object` has no text `key`.
inline std::string text_in(const nlohmann::json& object, const char* key) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

/// Returns 0 if `object` has no number `key`.
inline std::int64_t number_in(const nlohmann::json& object, const char* key) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    return found != object.end() && found->is_number_integer() ? found->get<std::int64_t>() : 0;
}

}  // namespace pxpl5::host

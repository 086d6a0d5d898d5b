#include "host/machine/computers/join/letter.hpp"

#include <fmt/core.h>

#include <cstddef>
#include <fstream>
#include <system_error>
#include <utility>

namespace pxpl5::host {

namespace {

constexpr std::size_t part_bytes = std::size_t{1} << 16;             // Beats wait behind each part.
constexpr std::uintmax_t max_log_bytes = std::uintmax_t{256} << 10;  // The end of a longer log.

}  // namespace

join::LetterT unpacked_letter(std::span<const std::uint8_t> bytes) {
    flatbuffers::Verifier verifier(bytes.data(), bytes.size());
    if (bytes.size() < sizeof(flatbuffers::uoffset_t) || !join::VerifyLetterBuffer(verifier)) {
        throw BadLetter(fmt::format("{} bytes are no letter of pxpl5 join", bytes.size()));
    }
    join::LetterT letter;
    join::GetLetter(bytes.data())->UnPackTo(&letter);
    return letter;
}

void send_content(const std::filesystem::path& folder, const std::string& file,
                  const std::function<void(join::ContentT)>& say) {
    const std::filesystem::path path = folder / file;
    join::ContentT part;
    part.file = file;
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    std::ifstream stream(path, std::ios::binary);
    const bool is_inside = file.find("..") == std::string::npos && !file.starts_with('/');
    if (error || !stream || !is_inside) {
        part.is_last = true;
        part.error = "cannot be read: " + (error ? error.message() : "no such file");
        return say(std::move(part));
    }
    if (file.ends_with(".log") && size > max_log_bytes) {
        stream.seekg(static_cast<std::streamoff>(size - max_log_bytes));
    }
    do {
        join::ContentT next;
        next.file = file;
        next.bytes.resize(part_bytes);
        stream.read(reinterpret_cast<char*>(next.bytes.data()),
                    static_cast<std::streamsize>(next.bytes.size()));
        next.bytes.resize(static_cast<std::size_t>(stream.gcount()));
        next.is_last = !stream;
        if (stream.bad()) {
            next.error = "is cut off: it could not be read to its end";
        }
        say(std::move(next));
    } while (stream);
}

}  // namespace pxpl5::host

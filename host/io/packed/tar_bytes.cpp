#include "host/io/packed/tar_bytes.hpp"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "host/io/formats/byte_source.hpp"
#include "host/io/packed/archive_reader.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

int filter_of(Compression compression) {
    return compression == Compression::bzip2 ? ARCHIVE_FILTER_BZIP2
           : compression == Compression::xz  ? ARCHIVE_FILTER_XZ
                                             : ARCHIVE_FILTER_ZSTD;
}

bool begins_as_gzip(const fs::path& path, std::uint64_t first) {
    std::ifstream file(path, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(first));
    return file.get() == 0x1f && file.get() == 0x8b;
}

/// Throws ImportError unless the bytes of the file from `first` on are zeros.
void check_rest(const fs::path& path, std::uint64_t first) {
    std::ifstream file(path, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(first));
    std::vector<char> block(archive_block_bytes);
    do {
        file.read(block.data(), static_cast<std::streamsize>(block.size()));
        if (std::any_of(block.begin(), block.begin() + file.gcount(),
                        [](char c) { return c != 0; })) {
            throw ImportError(
                fmt::format("{}: goes on after the end of its compressed data, at "
                            "byte {}. Copy or download it again, or unpack it with "
                            "another program",
                            path.string(), first));
        }
    } while (file);
}

}  // namespace

struct TarBytes::Source {
    virtual ~Source() = default;
    /// Fills `out`; fewer bytes only at the end.
    virtual std::size_t read(std::span<std::byte> out) = 0;
};

/// Without compression, or with gzip, whose checksum libarchive does not compare.
struct TarBytes::Stored : Source {
    Stored(const fs::path& path, Compression compression)
        : file(path),
          bytes(path, compression == Compression::gzip ? Encoding::gzip : Encoding::raw, 0) {}

    std::size_t read(std::span<std::byte> out) override {
        const std::size_t got = bytes.read(out);
        if (got < out.size()) {
            const std::uint64_t rest = bytes.bytes_after_end();
            const std::uint64_t end = fs::file_size(file) - rest;
            const std::string damage = bytes.damage();
            if (!damage.empty() && (rest == 0 || begins_as_gzip(file, end))) {
                throw ImportError(fmt::format("{}: cannot be unpacked{}. Copy or download it again",
                                              file.string(), damage));
            }
            check_rest(file, end);
        }
        return got;
    }

    fs::path file;
    ByteSource bytes;
};

struct TarBytes::Filtered : Source {
    Filtered(const fs::path& path, Compression compression)
        : file(path), reader(new_archive_reader()) {
        // libarchive would take away one layer after the other.
        archive_read_append_filter(reader.get(), filter_of(compression));
        archive_read_support_format_raw(reader.get());
        archive_entry* entry = nullptr;
        if (archive_read_open_filename(reader.get(), path.c_str(), archive_block_bytes) !=
                ARCHIVE_OK ||
            archive_read_next_header(reader.get(), &entry) != ARCHIVE_OK) {
            (void)reason_of(reader.get());  // It says that it does not know what raw bytes are.
            refuse("");
        }
    }

    std::size_t read(std::span<std::byte> out) override {
        const la_ssize_t got = archive_read_data(reader.get(), out.data(), out.size());
        if (got < 0) {
            refuse(fmt::format(" ({})", reason_of(reader.get())));
        }
        if (got == 0) {
            constexpr int of_file = -1;
            check_rest(file,
                       static_cast<std::uint64_t>(archive_filter_bytes(reader.get(), of_file)));
        }
        return static_cast<std::size_t>(got);
    }

    [[noreturn]] void refuse(const std::string& reason) const {
        throw ImportError(
            fmt::format("{}: cannot be unpacked; its compressed data are broken or "
                        "cut{}. Copy or download it again",
                        file.string(), reason));
    }

    fs::path file;
    ArchiveReader reader;
};

TarBytes::TarBytes(const fs::path& path, Compression compression, std::uint64_t most_bytes)
    : file_(path.string()), most_bytes_(most_bytes), block_(archive_block_bytes) {
    if (compression == Compression::none || compression == Compression::gzip) {
        source_ = std::make_unique<Stored>(path, compression);
    } else {
        source_ = std::make_unique<Filtered>(path, compression);
    }
}

TarBytes::~TarBytes() = default;

std::span<const std::byte> TarBytes::next() {
    const std::span<std::byte> got = std::span(block_).first(source_->read(block_));
    const auto last =
        std::find_if(got.rbegin(), got.rend(), [](std::byte b) { return b != std::byte{}; });
    if (last != got.rend()) {
        count_without_zeros_ = count_ + static_cast<std::uint64_t>(got.rend() - last);
    }
    count_ += got.size();
    if (count_ > most_bytes_) {
        throw ImportError(
            fmt::format("{}: unpacks to more than {} bytes. Unpack it with another "
                        "program, and load the folder of one series",
                        file_, most_bytes_));
    }
    return got;
}

}  // namespace pxpl5::host::io

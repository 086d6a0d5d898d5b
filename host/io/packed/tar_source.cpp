#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include "host/io/formats/first_bytes.hpp"
#include "host/io/packed/archive_reader.hpp"
#include "host/io/packed/archive_source.hpp"
#include "host/io/packed/tar_bytes.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t tar_block_bytes = 512;
constexpr std::uint64_t tar_record_bytes = 20 * tar_block_bytes;  // GNU's, libarchive's, Python's.

/// The compression by the first bytes.
Compression compression_of(const fs::path& path) {
    using namespace std::string_view_literals;
    const std::string first = first_bytes(path);
    if (begins_as_tar(first)) {
        return Compression::none;  // It begins with a name.
    }
    const std::array<std::pair<std::string_view, Compression>, 4> marks = {{
        {"\x1f\x8b", Compression::gzip},
        {"BZh", Compression::bzip2},
        {"\xfd\x37zXZ\0"sv, Compression::xz},
        {"\x28\xb5\x2f\xfd", Compression::zstd},
    }};
    const auto mark = std::ranges::find_if(
        marks, [&](const auto& each) { return first.starts_with(each.first); });
    return mark == marks.end() ? Compression::none : mark->second;
}

/// Whether this is GNU tar's second or later part of an archive: it goes on with a file (type M),
/// or has a label (type V, or a pax header of type g) that ends in "Volume N". `head`: first bytes.
bool is_later_part(std::string_view head) {
    constexpr std::size_t type_at = 156, name_bytes = 100;
    const auto type = [&](std::size_t block) {
        const std::size_t at = block * tar_block_bytes + type_at;
        return at < head.size() ? head[at] : '\0';
    };
    if (type(0) == 'M' || (type(0) == 'V' && type(1) == 'M')) {
        return true;
    }
    std::string_view label;
    if (type(0) == 'V') {
        label = head.substr(0, name_bytes);
    } else if (type(0) == 'g') {
        constexpr std::string_view key = "GNU.volume.label=";
        const std::string_view text =
            head.substr(std::min<std::size_t>(tar_block_bytes, head.size()));
        const std::string_view first_block = text.substr(0, tar_block_bytes);
        if (first_block.find("GNU.volume.filename=") != std::string_view::npos) {
            return true;
        }
        const std::size_t at = first_block.find(key);
        label = at == std::string_view::npos ? "" : first_block.substr(at + key.size());
    }
    label = label.substr(0, label.find_first_of(std::string_view("\0\n", 2)));
    constexpr std::string_view volume = " Volume ";
    const std::size_t at = label.rfind(volume);
    if (at == std::string_view::npos) {
        return false;
    }
    const std::string_view number = label.substr(at + volume.size());
    return !number.empty() && number != "1" &&
           number.find_first_not_of("0123456789") == std::string_view::npos;
}

class TarSource : public ArchiveSource {
  public:
    TarSource(const fs::path& path, std::uint64_t most_bytes)
        : file_(path.string()),
          compression_(compression_of(path)),
          bytes_(path, compression_, most_bytes),
          reader_(new_archive_reader()) {
        archive_read_support_format_tar(reader_.get());
        archive_read_set_read_callback(reader_.get(), read_bytes);
        archive_read_set_callback_data(reader_.get(), this);
        if (archive_read_open1(reader_.get()) != ARCHIVE_OK) {
            refuse("is no ZIP or tar archive, or is damaged or cut");
        }
    }

    std::optional<PackedEntry> next() override {
        archive_entry* entry = nullptr;
        const int status = archive_read_next_header(reader_.get(), &entry);
        if (failure_ || (status != ARCHIVE_EOF && status != ARCHIVE_OK && status != ARCHIVE_WARN)) {
            refuse(fmt::format("is damaged or cut after {} files, folders and links", count_));
        }
        if (status == ARCHIVE_EOF) {
            check_end();
            return std::nullopt;
        }
        ++count_;
        const char* name = archive_entry_pathname_utf8(entry);
        name = name == nullptr ? archive_entry_pathname(entry) : name;
        const auto type = archive_entry_filetype(entry);
        const auto size =
            static_cast<std::uint64_t>(std::max<la_int64_t>(archive_entry_size(entry), 0));
        hole_bytes_ = archive_entry_sparse_count(entry) > 0 ? size : 0;
        return PackedEntry{name == nullptr ? fmt::format("file {}", count_) : name, size,
                           type == AE_IFDIR && size == 0,
                           archive_entry_hardlink(entry) != nullptr || type == AE_IFLNK,
                           archive_entry_is_data_encrypted(entry) != 0};
    }

    std::size_t read(std::span<char> out) override {
        la_ssize_t got = archive_read_data(reader_.get(), out.data(), out.size());
        if (failure_ || got == ARCHIVE_FATAL) {
            refuse(fmt::format("is damaged or cut in file {}", count_));
        }
        if (got < 0) {
            throw UnreadableEntry(reason_of(reader_.get()));
        }
        if (got == 0 && hole_bytes_ > 0) {
            got = static_cast<la_ssize_t>(std::min<std::uint64_t>(hole_bytes_, out.size()));
            std::fill_n(out.begin(), got, '\0');
        }
        hole_bytes_ -= std::min(hole_bytes_, static_cast<std::uint64_t>(got));
        return static_cast<std::size_t>(got);
    }

  private:
    static la_ssize_t read_bytes(archive* reader, void* self, const void** out) {
        auto& source = *static_cast<TarSource*>(self);
        try {
            const bool is_first = source.bytes_.count() == 0;
            const std::span<const std::byte> next = source.bytes_.next();
            if (is_first) {
                source.check_first(next);
            }
            *out = next.data();
            return static_cast<la_ssize_t>(next.size());
        } catch (...) {
            source.failure_ = std::current_exception();
            archive_set_error(reader, EIO, "its bytes cannot be read");
            return ARCHIVE_FATAL;
        }
    }

    [[noreturn]] void refuse(const std::string& what) const {
        if (failure_) {
            std::rethrow_exception(failure_);
        }
        throw ImportError(
            fmt::format("{}: {} ({}). Copy or download it again, or unpack it with another program",
                        file_, what, reason_of(reader_.get())));
    }

    void check_first(std::span<const std::byte> bytes) const {
        if (is_later_part({reinterpret_cast<const char*>(bytes.data()), bytes.size()})) {
            throw ImportError(
                fmt::format("{}: is a later part of a tar archive of several parts. "
                            "Unpack them with another program, and load the folder",
                            file_));
        }
    }

    /// A tar archive ends with blocks of zeros. Without them, files may be missing; with more after
    /// them, it is several archives. Checksums behind the last byte are compared, too.
    void check_end() {
        while (!bytes_.next().empty()) {
        }
        const auto end = static_cast<std::uint64_t>(archive_read_header_position(reader_.get()));
        if (bytes_.count() < end + tar_block_bytes) {
            throw ImportError(fmt::format(
                "{}: is cut: the block of zeros that ends a tar archive is missing after {} "
                "files, folders and links. Copy or download it again",
                file_, count_));
        }
        if (bytes_.count_without_zeros() > end) {
            throw ImportError(
                fmt::format("{}: goes on after the end of the tar archive, which is at byte {} of "
                            "the {} that are unpacked. Unpack it with another program, and load "
                            "the folder",
                            file_, end, bytes_.count()));
        }
        // Zeros that were never written look like the end. A checksum would say so.
        const std::uint64_t records =
            (end + 2 * tar_block_bytes + tar_record_bytes - 1) / tar_record_bytes;
        if (compression_ == Compression::none && bytes_.count() > records * tar_record_bytes) {
            throw ImportError(fmt::format(
                "{}: has {} bytes of zeros after {} files, folders and links, more than the end of "
                "a tar archive needs: the rest may not have been copied. Copy or download it "
                "again; if it is whole, unpack it with another program, and load the folder",
                file_, bytes_.count() - end, count_));
        }
    }

    std::string file_;
    Compression compression_;
    TarBytes bytes_;
    std::size_t count_ = 0;  ///< Files, folders and links so far.
    /// Bytes of the present file still to come, if it is sparse: libarchive may leave out its last
    /// zeros.
    std::uint64_t hole_bytes_ = 0;
    std::exception_ptr failure_;  ///< The error of bytes_, while libarchive was asking for more.
    ArchiveReader reader_;
};

}  // namespace

std::unique_ptr<ArchiveSource> open_tar(const fs::path& path, std::uint64_t most_bytes) {
    return std::make_unique<TarSource>(path, most_bytes);
}

}  // namespace pxpl5::host::io

#include <fmt/format.h>
#include <sys/stat.h>
#include <zip.h>

#include <algorithm>
#include <fstream>
#include <new>
#include <string>
#include <string_view>

#include "host/io/packed/archive_source.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

struct CloseZip {
    void operator()(zip_t* archive) const { zip_discard(archive); }
};

struct CloseZipFile {
    void operator()(zip_file_t* file) const { zip_fclose(file); }
};

template <typename T>
T little_endian(std::string_view bytes, std::size_t at) {
    T value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
        const auto byte = static_cast<T>(static_cast<unsigned char>(bytes[at + i]));
        value = static_cast<T>(value | byte << 8 * i);
    }
    return value;
}

/// At most `size` bytes of the file from `first` on.
std::string bytes_from(const fs::path& path, std::uint64_t first, std::uint64_t size) {
    std::string bytes(size, '\0');
    std::ifstream file(path, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(first));
    file.read(bytes.data(), static_cast<std::streamsize>(size));
    bytes.resize(static_cast<std::size_t>(file.gcount()));
    return bytes;
}

struct Directory {
    std::uint64_t files = 0, first = 0, size = 0, end = 0;  ///< Bytes; `end` is the byte behind it.
};

/// The directory as the record at the end of the file describes it (APPNOTE.TXT 6.3.10 of PKWARE,
/// 4.3.14 to 4.3.16), and where it ends in fact. None if the file does not end with such a record.
std::optional<Directory> directory_of(const fs::path& path) {
    using namespace std::string_view_literals;
    constexpr std::uint64_t record_bytes = 22, locator_bytes = 20, record64_bytes = 56;
    constexpr std::uint64_t most_comment_bytes = 65'535;
    const std::uint64_t size = fs::file_size(path);
    const std::uint64_t tail_bytes =
        std::min(size, record_bytes + most_comment_bytes + locator_bytes);
    const std::string tail = bytes_from(path, size - tail_bytes, tail_bytes);
    std::size_t at = tail.rfind("PK\5\6"sv);
    while (at != std::string::npos &&
           (at + record_bytes > tail.size() ||
            at + record_bytes + little_endian<std::uint16_t>(tail, at + 20) != tail.size())) {
        at = at == 0 ? std::string::npos : tail.rfind("PK\5\6"sv, at - 1);
    }
    if (at == std::string::npos) {
        return std::nullopt;
    }
    Directory found{little_endian<std::uint16_t>(tail, at + 10),
                    little_endian<std::uint32_t>(tail, at + 16),
                    little_endian<std::uint32_t>(tail, at + 12), size - tail_bytes + at};
    if (at >= locator_bytes && tail.compare(at - locator_bytes, 4, "PK\6\7") == 0) {
        found.end = little_endian<std::uint64_t>(tail, at - locator_bytes + 8);
        const std::string record = bytes_from(path, found.end, record64_bytes);
        if (record.size() != record64_bytes || !record.starts_with("PK\6\6")) {
            return std::nullopt;
        }
        found.files = little_endian<std::uint64_t>(record, 32);
        found.size = little_endian<std::uint64_t>(record, 40);
        found.first = little_endian<std::uint64_t>(record, 48);
    }
    return found;
}

class ZipSource : public ArchiveSource {
  public:
    explicit ZipSource(const fs::path& path) : file_bytes_(fs::file_size(path)) {
        int code = 0;
        archive_.reset(zip_open(path.c_str(), ZIP_RDONLY, &code));
        if (archive_) {
            count_ = static_cast<zip_uint64_t>(zip_get_num_entries(archive_.get(), 0));
            check_whole(path);
            return;
        }
        zip_error_t error;
        zip_error_init_with_code(&error, code);
        const std::string reason = shown(zip_error_strerror(&error));
        zip_error_fini(&error);
        if (code == ZIP_ER_MEMORY) {
            throw std::bad_alloc();
        }
        throw ImportError(
            fmt::format("{}: is no ZIP archive, or is damaged or cut ({}). Copy or "
                        "download it again, or unpack it with another program",
                        path.string(), reason));
    }

    std::optional<PackedEntry> next() override {
        file_.reset();
        if (next_ == count_) {
            return std::nullopt;
        }
        at_ = next_++;
        zip_stat_t facts;
        zip_stat_init(&facts);
        if (zip_stat_index(archive_.get(), at_, 0, &facts) != 0) {
            return PackedEntry{fmt::format("file {}", next_)};  // read() says why.
        }
        const std::string_view name = facts.name == nullptr ? "" : facts.name;
        // A size that these bytes cannot have is not worth memory.
        constexpr std::uint64_t max_deflate_ratio = 1032;
        const std::uint64_t most = max_deflate_ratio * std::min(facts.comp_size, file_bytes_);
        return PackedEntry{std::string(name), std::min(facts.size, most),
                           facts.size == 0 && name.ends_with('/'), is_link(),
                           facts.encryption_method != ZIP_EM_NONE};
    }

    std::size_t read(std::span<char> out) override {
        if (!file_) {
            file_.reset(zip_fopen_index(archive_.get(), at_, 0));
            if (!file_) {
                refuse(zip_get_error(archive_.get()));
            }
        }
        const zip_int64_t got = zip_fread(file_.get(), out.data(), out.size());
        if (got < 0) {
            refuse(zip_file_get_error(file_.get()));
        }
        return static_cast<std::size_t>(got);
    }

  private:
    bool is_link() const {
        zip_uint8_t system = ZIP_OPSYS_DOS;
        zip_uint32_t attributes = 0;
        zip_file_get_external_attributes(archive_.get(), at_, 0, &system, &attributes);
        constexpr unsigned mode_bit = 16;
        return system == ZIP_OPSYS_UNIX && S_ISLNK(attributes >> mode_bit);
    }

    /// libzip looks for a directory that fits, so it would read one of several archives in a file.
    void check_whole(const fs::path& path) const {
        const std::optional<Directory> directory = directory_of(path);
        const std::string where = path.string();
        constexpr const char* remedy =
            "Copy or download it again, or unpack it with another program, and load the folder";
        if (!directory) {
            throw ImportError(fmt::format(
                "{}: is not one whole ZIP archive: it does not end with the record that a ZIP "
                "archive ends with. {}",
                where, remedy));
        }
        if (directory->files != count_ || directory->first + directory->size != directory->end) {
            throw ImportError(fmt::format(
                "{}: is not one whole ZIP archive: its directory should have {} files and end at "
                "byte {}, but has {} and ends at byte {}. {}",
                where, directory->files, directory->first + directory->size, count_, directory->end,
                remedy));
        }
    }

    [[noreturn]] static void refuse(zip_error_t* error) {
        if (zip_error_code_zip(error) == ZIP_ER_MEMORY) {
            throw std::bad_alloc();
        }
        throw UnreadableEntry(shown(zip_error_strerror(error)));
    }

    std::uint64_t file_bytes_;
    std::unique_ptr<zip_t, CloseZip> archive_;
    std::unique_ptr<zip_file_t, CloseZipFile> file_;  ///< Closed before the archive.
    zip_uint64_t count_ = 0, next_ = 0, at_ = 0;
};

}  // namespace

std::unique_ptr<ArchiveSource> open_zip(const fs::path& path) {
    return std::make_unique<ZipSource>(path);
}

}  // namespace pxpl5::host::io

#include "host/io/packed/packed_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <ranges>
#include <set>
#include <string_view>
#include <utility>

#include "host/base/kernel/standard_streams.hpp"
#include "host/io/dicom/dicom_file.hpp"
#include "host/io/formats/first_bytes.hpp"
#include "host/io/formats/picture_stack.hpp"
#include "host/io/packed/archive_source.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t block_bytes = 1 << 16;
constexpr std::size_t max_name_bytes = 4096;
constexpr std::uint64_t most_reserved_bytes = 1U << 30;  // An archive may state any size.

/// One file of the archive.
struct Packed {
    std::string name;                          ///< The path in the archive: "CT/IM7".
    std::shared_ptr<const std::string> bytes;  ///< Null if it is no DICOM file.
    std::string unreadable;                    ///< Why, if it cannot be read.
};

class Unpacker {
  public:
    Unpacker(const fs::path& path, std::uint64_t most_bytes)
        : file_(path.string()), most_bytes_(most_bytes), most_read_(2 * most_bytes) {
        source_ = begins_as_zip(first_bytes(path)) ? open_zip(path) : open_tar(path, most_read_);
    }

    PackedFiles all() {
        PackedFiles found;
        std::vector<Packed> files;
        std::size_t entries = 0;
        while (const std::optional<PackedEntry> entry = source_->next()) {
            if (++entries > max_packed_entries) {
                throw ImportError(
                    fmt::format("{}: has more than {} files, folders and links. "
                                "Unpack it, and load the folder of one series",
                                file_, max_packed_entries));
            }
            if (entry->is_folder) {
                continue;
            }
            files.push_back(read(*entry));
            if (!files.back().bytes && files.back().unreadable.empty()) {
                files.pop_back();
                ++(entry->is_link ? found.links : found.others);
            }
        }
        // The last of several files with one name has it, as on a disk.
        std::set<std::string> names;
        for (Packed& packed : files | std::views::reverse) {
            std::string name = file_ + "/" + packed.name;
            bool is_repeated = false;
            for (std::size_t n = 1; !names.insert(name).second; ++n) {
                is_repeated = true;
                name = fmt::format("{}/{} (earlier file {})", file_, packed.name, n);
            }
            found.repeated += is_repeated ? 1 : 0;
            if (packed.bytes) {
                found.dicom.emplace_back(name, std::move(packed.bytes));
            } else {
                found.unreadable.push_back(name + ": " + packed.unreadable);
            }
        }
        std::ranges::sort(found.dicom, [](const DicomInput& a, const DicomInput& b) {
            return is_naturally_before(a.path.string(), b.path.string());
        });
        std::ranges::sort(found.unreadable, is_naturally_before);
        return found;
    }

  private:
    /// A name with a leading / or with .. stays in the archive, and has no control characters.
    std::string name_of(const PackedEntry& entry) const {
        if (entry.name.size() > max_name_bytes) {
            throw ImportError(
                fmt::format("{}: a name of a file in it has {} bytes, must be at "
                            "most {}. Unpack it with another program",
                            file_, entry.name.size(), max_name_bytes));
        }
        std::string name =
            printable(fs::path(entry.name).relative_path().lexically_normal().string());
        std::ranges::replace_if(
            name, [](char c) { return c == '\t' || c == '\n'; }, '?');
        return name;
    }

    Packed read(const PackedEntry& entry) {
        Packed packed{name_of(entry), nullptr, ""};
        if (entry.has_password) {
            packed.unreadable =
                "is protected by a password. Unpack the archive with another program, and load the "
                "folder";
            return packed;
        }
        try {
            if (std::string bytes = bytes_of(entry); !bytes.empty()) {
                bytes_ += bytes.size();
                packed.bytes = std::make_shared<const std::string>(std::move(bytes));
            }
        } catch (const UnreadableEntry& error) {
            packed.unreadable = fmt::format(
                "cannot be unpacked ({}). Copy or download the archive again, or unpack it with "
                "another program",
                error.what());
        }
        return packed;
    }

    /// The bytes of a DICOM file; of another file none, after all have been read: its checksum says
    /// whether it is what it seems to be.
    std::string bytes_of(const PackedEntry& entry) {
        std::string bytes;
        std::array<char, block_bytes> block;
        bool is_first = true, is_dicom = false;
        while (const std::size_t count = source_->read(block)) {
            const std::string_view more(block.data(), count);
            read_ += count;
            if (read_ > most_read_) {
                throw ImportError(
                    fmt::format("{}: unpacks to more than {} bytes. Unpack it with another "
                                "program, and load the folder of one series",
                                file_, most_read_));
            }
            if (std::exchange(is_first, false)) {
                is_dicom = begins_as_dicom({entry.name, std::make_shared<const std::string>(more)});
                if (is_dicom) {
                    check_bytes(entry.size_bytes);
                    bytes.reserve(std::min(entry.size_bytes, most_reserved_bytes));
                }
            }
            if (is_dicom) {
                check_bytes(bytes.size() + count);
                bytes.append(more);
            }
        }
        return bytes;
    }

    void check_bytes(std::uint64_t more) const {
        if (more > most_bytes_ - bytes_) {
            throw ImportError(
                fmt::format("{}: its DICOM files have more than {} bytes. Unpack it, "
                            "and load the folder of one series",
                            file_, most_bytes_));
        }
    }

    std::string file_;
    std::uint64_t most_bytes_, most_read_;
    std::uint64_t bytes_ = 0, read_ = 0;  ///< Sizes of the DICOM files, and of all.
    std::unique_ptr<ArchiveSource> source_;
};

}  // namespace

PackedFiles unpack(const fs::path& archive, std::uint64_t most_bytes) {
    return Unpacker(archive, most_bytes).all();
}

}  // namespace pxpl5::host::io

// ZIP and tar archives in memory, written by libarchive.
#pragma once

#include <archive.h>
#include <archive_entry.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pxpl5::test {

/// Names and contents, in the order of the archive. A name with / at its end is that of a folder,
/// and "name -> file" is a link.
using NamedBytes = std::vector<std::pair<std::string, std::string>>;

/// format       ARCHIVE_FORMAT_ZIP or ARCHIVE_FORMAT_TAR_USTAR.
/// compression  ARCHIVE_FILTER_ of a tar archive.
/// options      As "zip:compression=store".
/// password     Encrypts a ZIP archive if the options say so.
/// layers       How often the compression is applied.
/// stored       If not 0, the bytes of each file after so many are a hole of a sparse file.
inline std::string packed(const NamedBytes& files, int format = ARCHIVE_FORMAT_ZIP,
                          int compression = ARCHIVE_FILTER_NONE, const char* options = nullptr,
                          const char* password = nullptr, int layers = 1, std::size_t stored = 0) {
    const auto require = [](bool holds, archive* writer) {
        if (!holds) {
            throw std::runtime_error(archive_error_string(writer));
        }
    };
    std::size_t size = 1 << 20;
    for (const auto& [name, bytes] : files) {
        size += 2 * bytes.size() + 4096;
    }
    std::string all(size, '\0');
    archive* const writer = archive_write_new();
    const std::shared_ptr<void> closer(
        writer, [](void* opened) { archive_write_free(static_cast<archive*>(opened)); });
    require(archive_write_set_format(writer, format) == ARCHIVE_OK, writer);
    for (int i = 0; i < layers; ++i) {
        require(archive_write_add_filter(writer, compression) == ARCHIVE_OK, writer);
    }
    require(archive_write_set_options(writer, options) == ARCHIVE_OK, writer);
    if (password != nullptr) {
        require(archive_write_set_passphrase(writer, password) == ARCHIVE_OK, writer);
    }
    std::size_t used = 0;
    require(archive_write_open_memory(writer, all.data(), all.size(), &used) == ARCHIVE_OK, writer);
    for (const auto& [name, bytes] : files) {
        const std::unique_ptr<archive_entry, decltype(&archive_entry_free)> entry(
            archive_entry_new(), &archive_entry_free);
        const std::size_t arrow = name.find(" -> ");
        archive_entry_set_pathname(entry.get(), name.substr(0, arrow).c_str());
        archive_entry_set_filetype(entry.get(), name.ends_with('/') ? AE_IFDIR : AE_IFREG);
        if (arrow != std::string::npos) {
            archive_entry_set_filetype(entry.get(), AE_IFLNK);
            archive_entry_set_symlink(entry.get(), name.substr(arrow + 4).c_str());
        }
        archive_entry_set_perm(entry.get(), 0600);
        archive_entry_set_size(entry.get(), static_cast<la_int64_t>(bytes.size()));
        if (stored > 0) {
            archive_entry_sparse_add_entry(entry.get(), 0, static_cast<la_int64_t>(stored));
        }
        require(archive_write_header(writer, entry.get()) == ARCHIVE_OK, writer);
        require(archive_write_data(writer, bytes.data(), bytes.size()) ==
                    static_cast<la_ssize_t>(bytes.size()),
                writer);
    }
    require(archive_write_close(writer) == ARCHIVE_OK, writer);
    all.resize(used);
    return all;
}

}  // namespace pxpl5::test

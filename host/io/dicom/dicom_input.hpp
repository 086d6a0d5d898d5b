// Where the bytes of a DICOM file are: in a stored file, or in memory, unpacked from an archive.
#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <memory>
#include <string>
#include <utility>

#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::host::io {

struct DicomInput {
    /// A stored file. Not explicit: most callers have a path.
    DicomInput(std::filesystem::path stored) : path(std::move(stored)) {}
    DicomInput(const std::string& stored) : path(stored) {}
    DicomInput(std::filesystem::path name, std::shared_ptr<const std::string> unpacked)
        : path(std::move(name)), bytes(std::move(unpacked)) {}

    std::filesystem::path path;                ///< A file in an archive is "scan.zip/CT/IM7".
    std::shared_ptr<const std::string> bytes;  ///< Null if the file is stored.

    /// Throws std::filesystem::filesystem_error.
    std::uint64_t size_bytes() const;

    /// Throws ImportError if it is no regular file.
    FileFacts facts() const;

    /// The bytes from the first on. The stream has failed if the file cannot be opened.
    std::unique_ptr<std::istream> open() const;
};

}  // namespace pxpl5::host::io

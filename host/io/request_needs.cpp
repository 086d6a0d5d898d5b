#include "host/io/request_needs.hpp"

#include <optional>
#include <system_error>

#include "host/base/part_file.hpp"
#include "host/io/formats/stored_header.hpp"
#include "host/io/picture/draw_marks.hpp"
#include "host/io/zarr/zarr_image.hpp"
#include "host/phantom/phantom.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;
namespace schema = bus::schema;

/// Files grow beyond their message: an OpenEXR file has 16 bytes per pixel, a vertex in an OBJ file
/// up to 100 characters.
constexpr std::uint64_t file_bytes_per_byte = 16, least_file_bytes = std::uint64_t{64} << 20;

fs::path folder_of(const fs::path& path) {
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// True if a file of this format can name further files beside itself.
bool names_data_files(Format format) {
    return format == Format::nrrd || format == Format::meta_image || format == Format::nifti;
}

std::optional<Format> known_format(const fs::path& path) {
    try {
        return format_of(path);
    } catch (const ImportError&) {
        return std::nullopt;  // The import then reports the same error.
    }
}

FileRules files_of_import(const schema::ImportVolume& request,
                          const std::vector<std::string>& allowed) {
    const fs::path path = request.path()->str();
    FileRules files;
    if (is_phantom(path.string())) {
        return files;
    }
    files.readable.push_back(path);
    std::error_code failure;
    if (!fs::exists(path, failure)) {
        files.listed.push_back(folder_of(path));  // For "did you mean".
        return files;
    }
    const bool is_folder = fs::is_directory(path, failure);
    const std::optional<Format> format =
        is_folder || request.raw() != nullptr ? std::nullopt : known_format(path);
    const bool names_others = is_folder || (format && names_data_files(*format));
    if (names_others && !is_folder) {
        files.readable.push_back(folder_of(path));
    }
    if (is_folder && is_zarr(path)) {
        files.readable.push_back(zarr_root(path));
    }
    if (names_others) {
        files.readable.insert(files.readable.end(), allowed.begin(), allowed.end());
    }
    return files;
}

/// Libraries read the number of processors and the time zone.
void add_system_files(FileRules& files) {
    files.readable.insert(files.readable.end(),
                          {"/sys/devices/system/cpu", "/etc/localtime", "/usr/share/zoneinfo"});
}

/// The folders in which the writer of `path` makes files: links lead to other folders.
std::vector<fs::path> written_folders(const fs::path& path) {
    std::vector<fs::path> folders = {folder_of(place_of(path))};
    if (const fs::path colors = color_file_of(path); !colors.empty()) {
        folders.push_back(folder_of(place_of(colors)));
    }
    return folders;
}

Needs needs_of_export(const fs::path& path, std::size_t request_bytes) {
    Needs needs;
    needs.task = Task::write;
    needs.files.readable.emplace_back(mark_font_file);
    needs.files.writable = written_folders(path);
    needs.file_bytes = least_file_bytes + file_bytes_per_byte * request_bytes;
    return needs;
}

}  // namespace

Needs needs_of(const bus::Message& request, const std::vector<std::string>& allowed) {
    Needs needs;
    if (const auto* import = request.as<schema::ImportVolume>()) {
        needs.files = files_of_import(*import, allowed);
    } else if (const auto* mesh = request.as<schema::ReadMesh>()) {
        needs.files.readable.emplace_back(mesh->path()->str());
    } else if (const auto* archive = request.as<schema::ReadArchive>()) {
        needs.files.readable.emplace_back(archive->path()->str());
    } else if (const auto* picture = request.as<schema::ExportPicture>()) {
        needs = needs_of_export(picture->path()->str(), request.bytes().size());
    } else if (const auto* surfaces = request.as<schema::ExportMesh>()) {
        needs = needs_of_export(surfaces->path()->str(), request.bytes().size());
    }
    add_system_files(needs.files);
    return needs;
}

Needs needs_of_survey(const std::string& path, const std::vector<std::string>& allowed) {
    Needs needs;
    needs.files.readable.emplace_back(path);
    std::error_code failure;
    if (fs::is_directory(path, failure)) {
        needs.files.readable.insert(needs.files.readable.end(), allowed.begin(), allowed.end());
    }
    add_system_files(needs.files);
    return needs;
}

}  // namespace pxpl5::host::io

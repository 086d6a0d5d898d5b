#include "host/io/folder_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <system_error>
#include <utility>

#include "host/base/part_file.hpp"
#include "host/io/dicom/dicom_file.hpp"
#include "host/io/formats/picture_stack.hpp"
#include "host/io/packed/packed_files.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

constexpr int max_folder_depth = 8;
constexpr std::size_t max_folder_files = 65'536;

/// True if `file` lies in `folder` or below. Both have no links.
bool lies_in(const fs::path& file, const fs::path& folder) {
    const fs::path name = file.lexically_relative(folder);
    return !name.empty() && *name.begin() != "..";
}

/// Throws ImportError if the link leads out of the folder and of the folders that are allowed: a
/// stranger's folder could show any picture of the user.
void check_link(const fs::path& link, const fs::path& folder, const AllowedFolders& allowed) {
    std::vector<std::string> folders = allowed;
    folders.push_back(folder.string());
    const fs::path file = fs::canonical(link);
    const bool is_inside = std::ranges::any_of(folders, [&](const std::string& each) {
        std::error_code failure;
        const fs::path real = fs::canonical(each, failure);
        return !failure && lies_in(file, real);
    });
    if (!is_inside) {
        throw ImportError(
            fmt::format("{}: is a link to {}, which lies outside of {}. If the link "
                        "is trusted, allow the folder of that file with --allow DIR",
                        link.string(), file.string(), folder.string()));
    }
}

/// All files of a folder and of those inside it, by name: folders have no order of their own.
std::vector<fs::path> files_of(const fs::path& folder) {
    if (is_of_kernel(folder)) {
        throw ImportError(folder.string() + ": is a folder of the kernel, not of stored files");
    }
    std::vector<fs::path> files;
    for (auto at = fs::recursive_directory_iterator(folder); at != fs::end(at); ++at) {
        if (at.depth() >= max_folder_depth) {
            at.disable_recursion_pending();
        }
        if (at->is_regular_file()) {
            files.push_back(at->path());
        }
        if (files.size() > max_folder_files) {
            throw ImportError(
                fmt::format("{}: has more than {} files", folder.string(), max_folder_files));
        }
    }
    std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
        return is_naturally_before(a.string(), b.string());
    });
    return files;
}

/// None of the directory of a disk, which begins as a DICOM file.
std::vector<DicomSlice> slices_of(const DicomInput& file) {
    return lower_case(file.path.filename().string()) == "dicomdir" ? std::vector<DicomSlice>{}
                                                                   : read_dicom_slices(file);
}

/// Adds the slices of one file, which `read` returns. Returns whether the file could be read.
bool add_slices(const fs::path& source, FolderFiles& found,
                const std::function<std::vector<DicomSlice>()>& read) {
    std::vector<DicomSlice> slices;
    try {
        slices = read();
    } catch (const NoSlices& error) {
        found.left_out.push_back({FindingKind::other_series, error.what()});
        return false;
    } catch (const ImportError& error) {
        found.left_out.push_back({FindingKind::missing_slices, error.what()});
        return false;
    }
    if (found.slices.size() + slices.size() > max_slices) {
        throw ImportError(fmt::format("{}: has more than {} slices", source.string(), max_slices));
    }
    found.others += slices.empty() ? 1 : 0;
    std::ranges::move(slices, std::back_inserter(found.slices));
    return true;
}

}  // namespace

FolderFiles look_through(const fs::path& folder, const AllowedFolders& allowed) {
    FolderFiles found;
    for (const fs::path& file : files_of(folder)) {
        const bool is_read = add_slices(folder, found, [&] {
            if (fs::is_symlink(file)) {
                check_link(file, folder, allowed);
            }
            return slices_of(file);
        });
        if (is_read && is_picture(file)) {
            found.pictures.push_back(file);
        }
    }
    return found;
}

FolderFiles look_through_archive(const fs::path& archive) {
    const PackedFiles files = unpack(archive);
    FolderFiles found;
    found.others = files.others;
    found.links = files.links;
    found.repeated = files.repeated;
    for (const std::string& text : files.unreadable) {
        found.left_out.push_back({FindingKind::missing_slices, text});
    }
    for (const DicomInput& file : files.dicom) {
        add_slices(archive, found, [&] { return slices_of(file); });
    }
    return found;
}

void report_left_out(const FolderFiles& files, Volume& volume) {
    constexpr std::size_t max_named = 16;
    for (std::size_t i = 0; i < std::min(files.left_out.size(), max_named); ++i) {
        const Finding& file = files.left_out[i];
        volume.findings.push_back({file.kind, file.text + ": this file is left out"});
    }
    if (files.left_out.size() > max_named) {
        volume.findings.push_back({FindingKind::missing_slices,
                                   fmt::format("{} more files cannot be read and are left out",
                                               files.left_out.size() - max_named)});
    }
    const auto note = [&](std::size_t count, const char* one, const char* more) {
        if (count > 0) {
            volume.findings.push_back(
                {FindingKind::note, count == 1 ? one : fmt::format("{} {}", count, more)});
        }
    };
    note(files.links, "1 link in the archive is not followed",
         "links in the archive are not followed");
    note(files.repeated, "1 file has the name of a later file in the archive",
         "files have the name of a later file in the archive");
    const bool are_pictures = files.slices.empty();
    const std::size_t pictures = files.pictures.size() + files.other_pictures;
    const std::size_t others = files.others - (are_pictures ? pictures : 0);
    if (are_pictures && files.other_pictures > 0) {
        volume.findings.push_back(
            {FindingKind::note, fmt::format("{} of {} pictures are of another kind and left out",
                                            files.other_pictures, pictures)});
    }
    if (others > 0) {
        const char* text = others == 1 ? "1 file is not a {0} and is left out"
                                       : "{1} files are not {0}s and are left out";
        volume.findings.push_back(
            {FindingKind::note,
             fmt::format(fmt::runtime(text), are_pictures ? "picture" : "DICOM image", others)});
    }
}

}  // namespace pxpl5::host::io

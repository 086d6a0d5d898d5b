#include "host/io/folder_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <system_error>
#include <utility>

#include "host/base/part_file.hpp"
#include "host/io/dicom/dicom_file.hpp"
#include "host/io/formats/picture_stack.hpp"
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

bool is_dicom_directory(const fs::path& file) {
    return lower_case(file.filename().string()) == "dicomdir";
}

}  // namespace

FolderFiles look_through(const fs::path& folder, const AllowedFolders& allowed) {
    FolderFiles found;
    for (const fs::path& file : files_of(folder)) {
        std::vector<DicomSlice> slices;
        try {
            if (fs::is_symlink(file)) {
                check_link(file, folder, allowed);
            }
            slices = is_dicom_directory(file) ? slices : read_dicom_slices(file);
        } catch (const NoSlices& error) {
            found.left_out.push_back({FindingKind::other_series, error.what()});
            continue;
        } catch (const ImportError& error) {
            found.left_out.push_back({FindingKind::missing_slices, error.what()});
            continue;
        }
        if (found.slices.size() + slices.size() > max_slices) {
            throw ImportError(
                fmt::format("{}: has more than {} slices", folder.string(), max_slices));
        }
        std::move(slices.begin(), slices.end(), std::back_inserter(found.slices));
        if (is_picture(file)) {
            found.pictures.push_back(file);
        }
        found.others += slices.empty() ? 1 : 0;
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

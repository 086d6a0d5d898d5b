#include "host/session/transfer/slices_file_check.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "host/base/error.hpp"
#include "host/base/kernel/answer_within.hpp"
#include "host/base/part_file.hpp"
#include "host/phantom/phantom.hpp"

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

/// A file system on a network may not answer.
constexpr std::int64_t answer_ms = 10'000;

/// The parts of a request that decide which files its io process may open.
struct Asked {
    std::string source;
    bool has_raw = false;
    std::vector<std::string> folders;
};

[[noreturn]] void refuse(const std::string& source, const std::string& reason) {
    throw RequestError(ExitCode::bad_data, fmt::format("{}: {}", source, reason));
}

/// Whether `file`, which has no links, lies in `folder` or below.
bool lies_in(const fs::path& file, const fs::path& folder) {
    std::error_code failure;
    const fs::path real = fs::canonical(folder, failure);
    const fs::path name = failure ? fs::path() : file.lexically_relative(real);
    return !name.empty() && *name.begin() != "..";
}

/// Whether a file of this format can name a data file: NRRD, MetaImage, NIfTI and Analyze. Any
/// suffix that no other format has may be that of an NRRD file.
bool names_data_file(const fs::path& source) {
    constexpr std::array<std::string_view, 3> nifti = {".nii", ".hdr", ".img"};
    constexpr std::array<std::string_view, 4> others = {".nrrd", ".nhdr", ".mha", ".mhd"};
    constexpr std::array<std::string_view, 6> whole = {".vtk", ".tif", ".tiff",
                                                       ".png", ".dcm", ".ima"};
    const std::string suffix = suffix_of(source);
    if (suffix == ".gz") {
        return std::ranges::count(nifti, suffix_of(source.stem())) != 0;
    }
    if (std::ranges::count(nifti, suffix) != 0 || std::ranges::count(others, suffix) != 0) {
        return true;
    }
    if (std::ranges::count(whole, suffix) != 0) {
        return false;
    }
    constexpr std::string_view magic = "NRRD000";
    std::array<char, magic.size()> begin{};
    std::ifstream(source, std::ios::binary).read(begin.data(), begin.size());
    return std::string_view(begin.data(), begin.size()) == magic;
}

/// Refuses a file that is not the one that the io process read. It lies at `place`.
void check_facts(const SlicesFile& file, const fs::path& place, const std::string& source) {
    constexpr std::int64_t ns_per_s = 1'000'000'000;
    struct stat now {};
    if (stat(place.c_str(), &now) != 0) {
        refuse(source, fmt::format("its data file {}: {}", file.path, std::strerror(errno)));
    }
    if (!S_ISREG(now.st_mode)) {
        refuse(source, fmt::format("its data file {} is no regular file", file.path));
    }
    const FileFacts facts{static_cast<std::uint64_t>(now.st_size), now.st_ino,
                          now.st_mtim.tv_sec * ns_per_s + now.st_mtim.tv_nsec};
    if (facts != file.facts) {
        refuse(source,
               fmt::format("its data file {} has {} bytes, inode {}, and changed at {} ns; the io "
                           "process read {} bytes, inode {}, changed at {} ns. Load it again when "
                           "it is complete",
                           file.path, facts.size_bytes, facts.inode, facts.modified_ns,
                           file.facts.size_bytes, file.facts.inode, file.facts.modified_ns));
    }
}

/// Refuses a file that the io process could not read itself, and one that has changed.
void check_file(const SlicesFile& file, const Asked& asked) {
    const std::string& source = asked.source;
    struct stat now {};
    if (stat(source.c_str(), &now) != 0 || !S_ISREG(now.st_mode)) {
        refuse(source, fmt::format("is no regular file, but the io process states that the GPs "
                                   "read the values from {}. Load the file of the volume",
                                   file.path));
    }
    std::error_code failure;
    const fs::path real = fs::canonical(file.path, failure);
    if (failure) {
        refuse(source, fmt::format("its data file {}: {}", file.path, failure.message()));
    }
    if (!fs::equivalent(real, source, failure)) {
        if (asked.has_raw || !names_data_file(source)) {
            refuse(source, fmt::format("the io process states the data file {}, but a file of this "
                                       "format has its values itself. Load it with read=host",
                                       file.path));
        }
        if (!lies_in(real, fs::absolute(source).parent_path()) &&
            std::ranges::none_of(asked.folders,
                                 [&](const auto& each) { return lies_in(real, each); })) {
            refuse(source, fmt::format("its data file {} lies outside of the header's folder. If "
                                       "the header is trusted, allow the folder of the data with "
                                       "--allow DIR",
                                       file.path));
        }
    }
    check_facts(file, real, source);
}

/// Refuses a file where the request has the host read the values.
void check_due(const SlicesFile& file, const bus::schema::ImportVolumeT& request) {
    const bool is_processed = !request.crop_first.empty() || !request.crop_size.empty() ||
                              !request.resample_size.empty() ||
                              !request.resample_spacing_mm.empty() || request.smooth_mm != 0;
    const std::string wish = request.read == ReadBy::host ? "has read=host"
                             : is_processed               ? "has crop=, resample= or smooth="
                             : is_phantom(request.path)   ? "is a phantom"
                                                          : "";
    if (!wish.empty()) {
        refuse(request.path,
               fmt::format("the io process states that the GPs read the values from {}, but the "
                           "request {}, so that the host reads them. Load it again",
                           file.path, wish));
    }
}

/// Calls `check`, and waits for the file system up to the limit.
template <class Check>
void within_limit(const SlicesFile& file, const std::string& source, Check check) {
    const auto checked = answer_within(answer_ms, [check] {
        check();
        return true;
    });
    if (!checked) {
        refuse(source,
               fmt::format("its data file {} cannot be checked: the file system does not answer "
                           "within {} s. Load it again when the file system answers",
                           file.path, answer_ms / 1000));
    }
}

}  // namespace

void check_slices_file(const SlicesFile& file, const bus::schema::ImportVolumeT& request,
                       const std::vector<std::string>& folders) {
    check_due(file, request);
    const Asked asked{request.path, request.raw != nullptr, folders};
    within_limit(file, asked.source, [file, asked] { check_file(file, asked); });
}

void check_unchanged(const SlicesFile& file, const std::string& source) {
    within_limit(file, source, [file, source] { check_facts(file, file.path, source); });
}

}  // namespace pxpl5::host

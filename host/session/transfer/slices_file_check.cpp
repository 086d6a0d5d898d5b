#include "host/session/transfer/slices_file_check.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>

#include "host/base/error.hpp"
#include "host/base/kernel/answer_within.hpp"
#include "host/base/part_file.hpp"
#include "host/phantom/phantom.hpp"

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

/// A file system on a network may not answer.
constexpr std::int64_t answer_ms = 10'000, answer_ms_per_file = 10;

/// The parts of a request that decide which files its io process may open.
struct Asked {
    std::string source;
    bool has_raw = false;
    std::vector<std::string> folders;
};

/// The stated file `at` lies where the one before it does, and was checked with it.
bool is_checked(const std::vector<SlicesFile>& files, std::size_t at) {
    return at > 0 && files[at].path == files[at - 1].path && files[at].facts == files[at - 1].facts;
}

[[noreturn]] void refuse(const std::string& source, const std::string& reason) {
    throw RequestError(ExitCode::bad_data, fmt::format("{}: {}", source, reason));
}

/// Folders without links, which exist.
class RealFolders {
  public:
    void add(const fs::path& folder) {
        std::error_code failure;
        const fs::path real = fs::canonical(folder, failure);
        if (!failure) {
            folders_.push_back(real);
        }
    }
    /// Whether `file`, which has no links, lies in one of the folders or below.
    bool hold(const fs::path& file) const {
        return std::ranges::any_of(folders_, [&](const fs::path& folder) {
            const fs::path name = file.lexically_relative(folder);
            return !name.empty() && *name.begin() != "..";
        });
    }

  private:
    std::vector<fs::path> folders_;
};

/// Whether a file of this format can name a data file: NRRD, MetaImage, NIfTI and Analyze. Any
/// suffix that no other format has may be that of an NRRD file.
bool names_data_file(const fs::path& source) {
    constexpr std::array<std::string_view, 3> nifti = {".nii", ".hdr", ".img"};
    constexpr std::array<std::string_view, 4> others = {".nrrd", ".nhdr", ".mha", ".mhd"};
    constexpr std::array<std::string_view, 7> whole = {".vtk", ".vti", ".tif", ".tiff",
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

/// Where the files of a request may lie.
class Places {
  public:
    explicit Places(const Asked& asked) : source_(asked.source) {
        struct stat now {};
        const bool exists = stat(source_.c_str(), &now) == 0;
        is_folder_ = exists && S_ISDIR(now.st_mode);
        is_file_ = exists && S_ISREG(now.st_mode);
        has_others_ = !asked.has_raw && (is_folder_ || (is_file_ && names_data_file(source_)));
        folders_.add(is_folder_ ? fs::path(source_) : fs::absolute(source_).parent_path());
        for (const std::string& folder : asked.folders) {
            folders_.add(folder);
        }
    }

    /// Refuses a file that the io process could not read itself, and one that has changed.
    void check(const SlicesFile& file) const {
        if (!is_folder_ && !is_file_) {
            refuse(source_, fmt::format("is no regular file and no folder, but the io process "
                                        "states that the GPs read the values from {}. Load the "
                                        "file of the volume",
                                        file.path));
        }
        std::error_code failure;
        const fs::path real = fs::canonical(file.path, failure);
        if (failure) {
            refuse(source_, fmt::format("its data file {}: {}", file.path, failure.message()));
        }
        if (is_folder_ || !fs::equivalent(real, source_, failure)) {
            check_other(file, real);
        }
        check_facts(file, real, source_);
    }

  private:
    void check_other(const SlicesFile& file, const fs::path& real) const {
        if (!has_others_) {
            refuse(source_,
                   fmt::format("the io process states the data file {}, but {}. Load it with "
                               "read=host",
                               file.path,
                               is_folder_ ? "raw= describes a file, and this is a folder"
                                          : "a file of this format has its values itself"));
        }
        if (!folders_.hold(real)) {
            refuse(source_,
                   fmt::format("its data file {} lies outside of {}. If the {} is trusted, allow "
                               "the folder of the data with --allow DIR",
                               file.path, is_folder_ ? "this folder" : "the header's folder",
                               is_folder_ ? "folder" : "header"));
        }
    }

    std::string source_;
    bool is_folder_ = false, is_file_ = false;
    bool has_others_ = false;  ///< Values may lie in other files than the source.
    RealFolders folders_;
};

/// Refuses a file where the request has the host read the values.
void check_due(const StoredVolume& stored, const bus::schema::ImportVolumeT& request) {
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
                           stored.files.front().path, wish));
    }
}

/// Calls `check` with the files, each once, and waits for the file system up to the limit.
template <class Check>
void within_limit(const StoredVolume& stored, const std::string& source, Check check) {
    const auto limit_ms =
        answer_ms + answer_ms_per_file * static_cast<std::int64_t>(stored.files.size());
    const auto checked = answer_within(limit_ms, [check, files = stored.files]() mutable {
        for (std::size_t at = 0; at < files.size(); ++at) {
            if (!is_checked(files, at)) {
                check(files[at]);
            }
        }
        return true;
    });
    if (!checked) {
        refuse(source,
               fmt::format("its data file {} cannot be checked: the file system does not answer "
                           "within {} s. Load it again when the file system answers",
                           stored.files.front().path, limit_ms / 1000));
    }
}

}  // namespace

void check_slices_files(const StoredVolume& stored, const bus::schema::ImportVolumeT& request,
                        const std::vector<std::string>& folders) {
    check_due(stored, request);
    const Asked asked{request.path, request.raw != nullptr, folders};
    within_limit(stored, asked.source,
                 [places = std::optional<Places>(), asked](const SlicesFile& file) mutable {
                     if (!places) {
                         places.emplace(asked);  // Asks the file system, too.
                     }
                     places->check(file);
                 });
}

void check_unchanged(const StoredVolume& stored, const std::string& source) {
    within_limit(stored, source,
                 [source](const SlicesFile& file) { check_facts(file, file.path, source); });
}

}  // namespace pxpl5::host

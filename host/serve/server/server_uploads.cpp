#include "host/serve/server/server_uploads.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace pxpl5::host::serve {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_part_bytes = 200;  // Of 255 that file systems take.
constexpr int max_depth = 8;
constexpr std::size_t max_batch_name = 64;
constexpr std::size_t max_name_bytes = 4096;  // With folders.
/// Before a file among several: the length of its name and its size.
constexpr std::size_t lengths_bytes = sizeof(std::uint32_t) + sizeof(std::uint64_t);

std::string cleaned_part(std::string_view part) {
    std::string clean;
    for (const char c : part) {
        const auto byte = static_cast<unsigned char>(c);
        clean += byte < ' ' || byte == 0x7f || c == '\\' ? '_' : c;
    }
    clean.erase(0, clean.find_first_not_of(". "));
    if (clean.size() <= max_part_bytes) {
        return clean;
    }
    // The end tells the format.
    std::string end = clean.substr(clean.size() - max_part_bytes);
    const auto is_tail = [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) == 0x80U; };
    end.erase(0, static_cast<std::size_t>(std::ranges::find_if_not(end, is_tail) - end.begin()));
    end.erase(0, end.find_first_not_of(". "));
    return end;
}

void check_batch(const std::string& name) {
    const auto is_odd = [](char c) {
        return !((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                 c == '-' || c == '_');
    };
    if (name.empty() || name.size() > max_batch_name || std::ranges::any_of(name, is_odd)) {
        throw UploadError{400, fmt::format("A batch name has 1 to {} letters, digits, '-' or "
                                           "'_', but this name is '{}'.",
                                           max_batch_name, name)};
    }
}

/// The only entry of a folder, if there is just one.
std::optional<fs::path> only_entry(const fs::path& folder) {
    fs::directory_iterator at(folder);
    if (at == fs::directory_iterator()) {
        return std::nullopt;
    }
    fs::path first = at->path();
    return ++at == fs::directory_iterator() ? std::optional(first) : std::nullopt;
}

/// The only header among the files of a folder: its data lie beside it, and it names them.
std::optional<fs::path> only_header(const fs::path& folder) {
    constexpr std::array<std::string_view, 3> header_extensions{".mhd", ".nhdr", ".hdr"};
    std::optional<fs::path> header;
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (std::ranges::find(header_extensions, entry.path().extension()) ==
            header_extensions.end()) {
            continue;
        }
        if (header) {
            return std::nullopt;
        }
        header = entry.path();
    }
    return header;
}

bool is_within(const fs::path& folder, const fs::path& path) {
    return std::ranges::mismatch(folder, path).in1 == folder.end();
}

}  // namespace

fs::path cleaned_name(std::string_view name) {
    fs::path path;
    int depth = 0;
    while (!name.empty()) {
        const std::size_t end = std::min(name.find('/'), name.size());
        const std::string part = cleaned_part(name.substr(0, end));
        name.remove_prefix(std::min(end + 1, name.size()));
        if (part.empty()) {
            continue;
        }
        if (++depth > max_depth) {
            return {};
        }
        path /= part;
    }
    return path;
}

UploadingFile::UploadingFile(Uploads& uploads, std::string batch, fs::path path,
                             std::uint64_t length)
    : uploads_(uploads), batch_(std::move(batch)), path_(std::move(path)), announced_(length) {
    fd_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (fd_ < 0 && errno == EEXIST) {
        throw UploadError{409, fmt::format("{} was uploaded already.", path_.filename().string())};
    }
    if (fd_ < 0) {
        throw UploadError{500, fmt::format("{} cannot be stored: {}.", path_.filename().string(),
                                           std::strerror(errno))};
    }
    uploads_.bytes_ += announced_;
    uploads_.files_ += 1;
    uploads_.batches_.at(batch_).under_way += 1;
}

UploadingFile::~UploadingFile() {
    if (fd_ < 0) {
        return;
    }
    close(fd_);
    unlink(path_.c_str());
    uploads_.bytes_ -= announced_;
    uploads_.files_ -= 1;
    uploads_.batches_.at(batch_).under_way -= 1;
}

void UploadingFile::append(std::string_view bytes) {
    received_ += bytes.size();
    if (received_ > announced_) {
        throw UploadError{
            400, fmt::format("{} bytes arrived, but {} were announced.", received_, announced_)};
    }
    while (!bytes.empty()) {
        const ssize_t written = write(fd_, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) {
            continue;
        }
        if (written < 0) {
            throw UploadError{507, fmt::format("{} cannot be stored: {}.",
                                               path_.filename().string(), std::strerror(errno))};
        }
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
}

void UploadingFile::finish() {
    if (received_ != announced_) {
        throw UploadError{
            400, fmt::format("{} bytes arrived, but {} were announced.", received_, announced_)};
    }
    close(std::exchange(fd_, -1));
    Uploads::Batch& batch = uploads_.batches_.at(batch_);
    batch.under_way -= 1;
    batch.files += 1;
    batch.bytes += announced_;
}

void UploadingFiles::append(std::string_view bytes) {
    while (!bytes.empty()) {
        if (file_) {
            const std::string_view part = bytes.substr(0, left_);
            file_->append(part);
            bytes.remove_prefix(part.size());
            left_ -= part.size();
        } else {
            std::uint32_t name_bytes = 0;
            if (head_.size() >= lengths_bytes) {
                std::memcpy(&name_bytes, head_.data(), sizeof name_bytes);
            }
            if (name_bytes > max_name_bytes) {
                throw UploadError{400, "The name of a file is too long."};
            }
            const std::size_t wanted = lengths_bytes + name_bytes;
            const std::string_view part = bytes.substr(0, wanted - head_.size());
            head_ += part;
            bytes.remove_prefix(part.size());
            begin_file();
        }
        if (file_ && left_ == 0) {
            file_->finish();
            file_.reset();
        }
    }
}

/// Begins the next file once its lengths and its name are there.
void UploadingFiles::begin_file() {
    if (head_.size() < lengths_bytes) {
        return;
    }
    std::uint32_t name_bytes = 0;
    std::memcpy(&name_bytes, head_.data(), sizeof name_bytes);
    if (name_bytes == 0) {
        throw UploadError{400, "A file has no name."};
    }
    if (head_.size() == lengths_bytes + name_bytes) {
        std::memcpy(&left_, head_.data() + sizeof name_bytes, sizeof left_);
        file_ = uploads_.begin(head_.substr(lengths_bytes), batch_, left_);
        head_.clear();
    }
}

void UploadingFiles::finish() const {
    if (file_ || !head_.empty()) {
        throw UploadError{400, "The request ends within a file."};
    }
}

Uploads::Batch& Uploads::open_batch(const std::string& name) {
    check_batch(name);
    if (const auto known = batches_.find(name); known != batches_.end()) {
        return known->second;
    }
    // Numbered, so that a name that comes again meets no files of its forerunner.
    fs::path folder;
    std::error_code error;
    do {
        folder = folder_ / fmt::format("{}-{}", ++batch_count_, name);
    } while (!fs::create_directory(folder, error) && !error);
    if (error) {
        throw UploadError{500, fmt::format("Uploads cannot be stored: {}.", error.message())};
    }
    return batches_[name] = {folder};
}

std::unique_ptr<UploadingFile> Uploads::begin(const std::string& name, const std::string& batch,
                                              std::uint64_t length) {
    const fs::path clean = cleaned_name(name);
    if (clean.empty()) {
        throw UploadError{400, fmt::format("A file cannot be named '{}'.", name)};
    }
    if (length <= max_upload_bytes) {
        make_room(length, 1);
    }
    if (length > max_upload_bytes - bytes_) {
        throw UploadError{
            413, fmt::format("{} is too large: {} bytes, but {} of {} are left.", clean.string(),
                             length, max_upload_bytes - bytes_, max_upload_bytes)};
    }
    if (files_ >= max_upload_files) {
        throw UploadError{
            413, fmt::format("The limit of {} uploaded files is reached.", max_upload_files)};
    }
    const fs::path path = open_batch(batch).folder / clean;
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    if (error) {
        throw UploadError{500,
                          fmt::format("{} cannot be stored: {}.", clean.string(), error.message())};
    }
    return std::make_unique<UploadingFile>(*this, batch, path, length);
}

UploadedBatch Uploads::done(const std::string& name) {
    const auto found = batches_.find(name);
    if (found == batches_.end() || found->second.files == 0) {
        throw UploadError{400, fmt::format("Batch '{}' contains no file.", name)};
    }
    if (found->second.under_way > 0) {
        throw UploadError{409, fmt::format("{} files of batch '{}' are still being uploaded.",
                                           found->second.under_way, name)};
    }
    const Batch batch = found->second;
    batches_.erase(found);
    complete_.push_back(batch);
    fs::path path = batch.folder;
    // A dropped folder comes as files below it: the folder's name is the one that people know.
    while (const auto only = only_entry(path)) {
        path = *only;
        if (!fs::is_directory(path)) {
            break;
        }
    }
    if (fs::is_directory(path)) {
        path = only_header(path).value_or(path);
    }
    const std::string known_as = path == batch.folder ? name : path.filename().string();
    return {path, known_as, batch.files};
}

void Uploads::opened(const fs::path& path) {
    for (Batch& batch : complete_) {
        batch.was_open |= batch.is_open;
        batch.is_open = is_within(batch.folder, path);
    }
}

void Uploads::make_room(std::uint64_t bytes, int files) {
    while (bytes > max_upload_bytes - bytes_ || files_ + files > max_upload_files) {
        const auto old = std::ranges::find_if(
            complete_, [](const Batch& batch) { return batch.was_open && !batch.is_open; });
        if (old == complete_.end()) {
            return;
        }
        std::error_code error;  // What cannot be removed now goes with the run's folder.
        fs::remove_all(old->folder, error);
        bytes_ -= old->bytes;
        files_ -= old->files;
        complete_.erase(old);
    }
}

}  // namespace pxpl5::host::serve

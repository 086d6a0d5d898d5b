// Files that viewers upload, below one folder, with limits.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pxpl5::host::serve {

inline constexpr std::uint64_t max_upload_bytes = 4ULL << 30U;  // At one time.
inline constexpr int max_upload_files = 100'000;

/// A request that cannot be obeyed, as HTTP says it.
struct UploadError {
    int status = 400;
    std::string text;  ///< A sentence.
};

class Uploads;

/// A file that is being received. Unless it is finished, it leaves nothing behind.
class UploadingFile {
  public:
    UploadingFile(Uploads& uploads, std::string batch, std::filesystem::path path,
                  std::uint64_t length);
    ~UploadingFile();
    UploadingFile(const UploadingFile&) = delete;
    UploadingFile& operator=(const UploadingFile&) = delete;

    /// Throws UploadError if the disk is full, or more comes than was announced.
    void append(std::string_view bytes);
    /// Throws UploadError if bytes are missing.
    void finish();

  private:
    Uploads& uploads_;
    std::string batch_;
    std::filesystem::path path_;
    std::uint64_t announced_ = 0, received_ = 0;
    int fd_ = -1;
};

/// Files that come in one request, one after the other. Each has the length of its name (4 bytes),
/// its size (8 bytes), both little-endian, its name and its contents.
class UploadingFiles {
  public:
    UploadingFiles(Uploads& uploads, std::string batch)
        : uploads_(uploads), batch_(std::move(batch)) {}
    /// All throw UploadError as Uploads and UploadingFile do.
    void append(std::string_view bytes);
    /// Throws UploadError if the last file is incomplete.
    void finish() const;

  private:
    void begin_file();

    Uploads& uploads_;
    std::string batch_;
    std::string head_;  ///< The next file's lengths and name, as far as they have come.
    std::unique_ptr<UploadingFile> file_;
    std::uint64_t left_ = 0;  ///< Bytes of `file_` to come.
};

/// A batch that is complete.
struct UploadedBatch {
    std::filesystem::path path;  ///< The file, or the folder if several came.
    std::string name;
    int files = 0;
};

/// Keeps batches that were open, so that a session can open them again, until their room is needed
/// for another upload. All functions throw UploadError.
class Uploads {
  public:
    explicit Uploads(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// name    As the browser has it, perhaps with folders.
    /// length  Bytes that will come.
    std::unique_ptr<UploadingFile> begin(const std::string& name, const std::string& batch,
                                         std::uint64_t length);
    /// Ends the batch; its name may be used again, for a folder of its own.
    UploadedBatch done(const std::string& batch);
    /// This path, which may lie anywhere, is open now and no other.
    void opened(const std::filesystem::path& path);

  private:
    friend class UploadingFile;
    struct Batch {
        std::filesystem::path folder;
        int files = 0, under_way = 0;
        std::uint64_t bytes = 0;
        bool is_open = false, was_open = false;
    };
    Batch& open_batch(const std::string& name);
    /// Removes batches that were open, the longest kept first, until so much more has room.
    void make_room(std::uint64_t bytes, int files);

    std::filesystem::path folder_;
    std::map<std::string, Batch, std::less<>> batches_;  ///< Incomplete batches, by name.
    std::vector<Batch> complete_;
    std::uint64_t bytes_ = 0;  ///< Stored or announced.
    int files_ = 0;            ///< Likewise.
    int batch_count_ = 0;
};

/// The path below a batch's folder for a name that a browser gave; empty if nothing of it remains.
/// It never leads up or out, has no hidden parts and no control characters.
std::filesystem::path cleaned_name(std::string_view name);

}  // namespace pxpl5::host::serve

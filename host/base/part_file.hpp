// A file that appears whole or not at all: written beside its place, then renamed.
#pragma once

#include <bit>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace pxpl5::host {

/// The path's suffix in small letters, with its dot.
std::string suffix_of(const std::filesystem::path& path);

/// The file that is written under the name `path`: links are followed, also to a file that does not
/// exist yet. A link of another user in a folder that all users may write, for example /tmp, is not
/// followed, because it could name any file of this user: the file then replaces the link.
std::filesystem::path place_of(const std::filesystem::path& path);

/// The file of colors that is written beside an OBJ file. Empty for other meshes.
std::filesystem::path color_file_of(const std::filesystem::path& mesh);

/// Why no file can be written as `path`: "FILE: its folder FOLDER does not exist", or FILE itself
/// is a folder or a device. Empty if nothing of this kind is in the way.
std::string wrong_place(const std::filesystem::path& path);

/// Returns whether `path` is a file or a folder of /proc or /sys. Such files call themselves
/// regular, but reading one (/proc/kmsg) may wait for ever.
bool is_of_kernel(const std::filesystem::path& path);

/// Why `path` cannot be read as a file: "does not exist", "is a FIFO, not a file", or the system's
/// reason. Empty if it can be read.
std::string why_unreadable(const std::filesystem::path& path);

/// A file until it is whole: written as `.NAME.RANDOM.part.SUFFIX` beside place_of(target), because
/// renaming within a folder is atomic. The name is new, so that no file of the user is written.
/// Removed with this object unless it was kept. Locked until then, which
/// remove_abandoned_parts() respects.
class PartFile {
  public:
    explicit PartFile(const std::filesystem::path& target);
    ~PartFile();
    PartFile(const PartFile&) = delete;
    PartFile& operator=(const PartFile&) = delete;

    /// For a library that writes the file itself. Whoever closes such a file must check that this
    /// has worked.
    const std::filesystem::path& path() const { return part_; }
    /// For a library that writes into an open file; null if the file could not be made. keep()
    /// finds failures, also of bytes that were still in a buffer.
    std::FILE* stream() const { return file_; }

    /// Appends. After a failure what follows is dropped, and keep() tells the reason.
    void write(std::string_view bytes);

    /// Appends numbers as they lie in memory, little endian.
    template <typename T>
    void write_raw(std::span<const T> values) {
        static_assert(std::is_trivially_copyable_v<T>);
        static_assert(std::endian::native == std::endian::little);
        write({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
    }

    /// Whether something could not be written, so that going on is in vain.
    bool has_failed() const { return failure_ != 0; }

    /// The system's error if the disk has no room for a file of `bytes`. Empty if it has room or
    /// does not report it. Allocates the room: the part is discarded afterwards, or gets its size
    /// back.
    std::string lack_of_room(std::uint64_t bytes) const;

    /// Hands the bytes to the disk; nothing is written afterwards. Returns why that failed, as "No
    /// space left on device", or nothing. For files that appear together: the first is kept once
    /// all have reached the disk.
    std::string finish();

    /// finish(), and gives the file its name: after a power failure the file is whole or the one
    /// before. Returns why that failed, or nothing.
    std::string keep();

  private:
    void note_failure();

    std::filesystem::path target_, part_;
    std::FILE* file_ = nullptr;
    int lock_ = -1;    ///< Descriptor of the same open file. Negative: not locked.
    int failure_ = 0;  ///< The first errno; 0 if all went well.
};

/// Removes the unfinished files of `target`, and the colors of an unfinished OBJ file, that have
/// changed since then: for a program whose writer was killed. Another program that writes the same
/// target at this moment gets an error.
void remove_parts_of(const std::filesystem::path& target, std::filesystem::file_time_type since);

/// Removes the unfinished files in the folder of `target` that lost their program a minute ago or
/// earlier: writer and host were both killed. A file that a program still writes is locked and
/// stays, and so does every file on a file system without locks. For a host that is about to write
/// `target`. Looks once at each folder, because a command may write thousands of pictures.
void remove_abandoned_parts(const std::filesystem::path& target);

/// Removes the files of up to four PartFiles that exist, for a handler of a signal that ends the
/// process.
void remove_part_files();

}  // namespace pxpl5::host

// The file that a library of others reads now, for the report if the library ends the process.
#pragma once

#include <atomic>
#include <string>

namespace pxpl5::host::io {

/// The name of that file; null if no library reads a file. Requests are served one at a time.
inline std::atomic<const char*> file_at_work{nullptr};

/// Sets file_at_work in its lifetime. `name` must live as long.
class FileAtWork {
  public:
    explicit FileAtWork(const std::string& name) : before_(file_at_work.exchange(name.c_str())) {}
    ~FileAtWork() { file_at_work = before_; }
    FileAtWork(const FileAtWork&) = delete;
    FileAtWork& operator=(const FileAtWork&) = delete;

  private:
    const char* before_;
};

}  // namespace pxpl5::host::io

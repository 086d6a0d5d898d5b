// A folder in memory for the files of a target.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "tests/fuzz/fuzz.hpp"

namespace pxpl5::fuzz {

/// Exists until the process ends. Files keep their names, so that an input always gives one result.
class Scratch {
  public:
    Scratch() {
        const bool has_memory = std::filesystem::is_directory("/dev/shm");
        std::string name = has_memory ? "/dev/shm/pxpl5-fuzz-XXXXXX" : "/tmp/pxpl5-fuzz-XXXXXX";
        require(mkdtemp(name.data()) != nullptr, "a folder in memory cannot be made");
        path_ = name;
    }
    ~Scratch() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::string at(const std::string& name) const { return (path_ / name).string(); }
    std::string write(const std::string& name, std::string_view bytes) const {
        std::ofstream(path_ / name, std::ios::binary) << bytes;
        return at(name);
    }
    /// Removes all files.
    void clear() const {
        for (const auto& entry : std::filesystem::directory_iterator(path_)) {
            std::filesystem::remove_all(entry);
        }
    }

  private:
    std::filesystem::path path_;
};

}  // namespace pxpl5::fuzz

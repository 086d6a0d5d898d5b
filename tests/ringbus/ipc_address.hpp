// Addresses for the links of tests, in a folder that is removed when the tests end.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace pxpl5::test {

class SocketFolder {
  public:
    SocketFolder() {
        std::string path =
            (std::filesystem::temp_directory_path() / "pxpl5-ringbus-XXXXXX").string();
        if (mkdtemp(path.data()) == nullptr) {
            throw std::runtime_error("cannot make " + path);
        }
        path_ = path;
    }
    ~SocketFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    SocketFolder(const SocketFolder&) = delete;
    SocketFolder& operator=(const SocketFolder&) = delete;
    std::string address(const std::string& name) const {
        return "ipc://" + (path_ / name).string();
    }

  private:
    std::filesystem::path path_;
};

inline std::string ipc_address(const std::string& name) {
    static const SocketFolder folder;
    return folder.address(name);
}

}  // namespace pxpl5::test

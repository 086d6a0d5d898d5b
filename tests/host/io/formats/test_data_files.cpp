// Headers that name their data in other files: those files lie in the header's folder.
#include <doctest/doctest.h>
#include <sys/stat.h>

#include <algorithm>

#include "host/io/import.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

const std::string secret(64, 's');

std::string nrrd_with(const std::string& data_file) {
    return "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspacings: 1 1 1\nencoding: raw\n"
           "data file: " +
           data_file + "\n\n";
}

std::string meta_with(const std::string& data_file) {
    return "ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementSpacing = 1 1 1\n"
           "ElementType = MET_UCHAR\nElementDataFile = " +
           data_file + "\n";
}

/// A header's folder beside one that holds a secret.
struct TwoFolders {
    TwoFolders() {
        std::filesystem::create_directories(base.file("scan/below"));
        std::filesystem::create_directories(base.file("private"));
        base.write("private/secret.raw", secret);
    }
    TemporaryFolder base;

    std::string error_of(const std::string& name, const std::string& header,
                         const std::vector<std::string>& allowed = {}) const {
        ImportRequest request;
        request.path = base.write("scan/" + name, header);
        request.allowed = allowed;
        try {
            const Volume volume = import_volume(request);
            CHECK(volume.values.size() == secret.size());
        } catch (const ImportError& error) {
            return error.what();
        }
        return "";
    }
    void check_refused(const std::string& name, const std::string& header) const {
        const std::string error = error_of(name, header);
        CAPTURE(error);
        CHECK(error.starts_with(base.file("scan/" + name) + ": its data file "));
        CHECK(error.find("lies outside of the header's folder") != std::string::npos);
        CHECK(error.find("--allow DIR") != std::string::npos);
        CHECK(error_of(name, header, {base.file("private")}).empty());
        CHECK(!error_of(name, header, {base.file("scan")}).empty());
    }
};

}  // namespace

TEST_SUITE("host/io/data_files") {
    TEST_CASE("a header that names a file elsewhere is refused unless its folder is allowed") {
        const TwoFolders folders;
        for (const std::string& elsewhere :
             {folders.base.file("private/secret.raw"), std::string("../private/secret.raw"),
              std::string("below/../../private/secret.raw")}) {
            CAPTURE(elsewhere);
            folders.check_refused("a.nhdr", nrrd_with(elsewhere));
            folders.check_refused("a.mhd", meta_with(elsewhere));
        }
        folders.check_refused("list.nhdr", nrrd_with("LIST\n../private/secret.raw"));
        folders.check_refused("list.mhd", meta_with("LIST\n../private/secret.raw"));
    }
    TEST_CASE("numbered files elsewhere are refused") {
        const TwoFolders folders;
        folders.base.write("private/s1.raw", secret.substr(0, 32));
        folders.base.write("private/s2.raw", secret.substr(0, 32));
        folders.check_refused("a.nhdr", nrrd_with("../private/s%d.raw 1 2 1"));
        folders.check_refused("a.mhd", meta_with("../private/s%d.raw 1 2 1"));
    }
    TEST_CASE("a link that leads out is refused, also as the image of a NIfTI header") {
        const TwoFolders folders;
        std::filesystem::create_symlink(folders.base.file("private/secret.raw"),
                                        folders.base.file("scan/link.raw"));
        std::filesystem::create_directory_symlink(folders.base.file("private"),
                                                  folders.base.file("scan/folder"));
        folders.check_refused("a.nhdr", nrrd_with("link.raw"));
        folders.check_refused("b.nhdr", nrrd_with("folder/secret.raw"));
    }
    TEST_CASE("files beside the header and below are read, by any name for them") {
        const TwoFolders folders;
        folders.base.write("scan/beside.raw", secret);
        folders.base.write("scan/below/deep.raw", secret);
        std::filesystem::create_symlink("below/deep.raw", folders.base.file("scan/inner.raw"));
        for (const std::string& name :
             {std::string("beside.raw"), std::string("./beside.raw"), std::string("below/deep.raw"),
              std::string("below/../beside.raw"), std::string("inner.raw"),
              folders.base.file("scan/below/deep.raw"),
              folders.base.file("scan/below/../beside.raw")}) {
            CAPTURE(name);
            CHECK(folders.error_of("a.nhdr", nrrd_with(name)).empty());
            CHECK(folders.error_of("a.mhd", meta_with(name)).empty());
        }
    }
    TEST_CASE("a FIFO as data is refused at once") {
        const TwoFolders folders;
        REQUIRE(mkfifo(folders.base.file("scan/pipe.raw").c_str(), 0600) == 0);
        CHECK(folders.error_of("a.nhdr", nrrd_with("pipe.raw")).find("it is no file") !=
              std::string::npos);
    }
}

#include <doctest/doctest.h>

#include <functional>

#include "host/serve/server/server_uploads.hpp"
#include "tests/host/serve/scratch_folder.hpp"

namespace pxpl5::host::serve {
namespace {

void upload(Uploads& uploads, const std::string& name, const std::string& batch,
            const std::string& text) {
    const auto file = uploads.begin(name, batch, text.size());
    file->append(text);
    file->finish();
}

int status_of(const std::function<void()>& act) {
    try {
        act();
        return 200;
    } catch (const UploadError& error) {
        return error.status;
    }
}

}  // namespace

TEST_CASE("a name from a browser never leads out of its folder") {
    CHECK(cleaned_name("head.nrrd") == "head.nrrd");
    CHECK(cleaned_name("study/series 1/1.dcm") == "study/series 1/1.dcm");
    CHECK(cleaned_name("../../etc/passwd") == "etc/passwd");
    CHECK(cleaned_name("/etc/passwd") == "etc/passwd");
    CHECK(cleaned_name("a/./../.ssh/b") == "a/ssh/b");
    CHECK(cleaned_name("..\\a\nb") == "_a_b");
    CHECK(cleaned_name(std::string("a\0b", 3)) == "a_b");
    CHECK(cleaned_name("") == "");
    CHECK(cleaned_name("../..") == "");
    CHECK(cleaned_name("1/2/3/4/5/6/7/8/9") == "");
    const std::string long_name = std::string(300, 'x') + ".nii.gz";
    CHECK(cleaned_name(long_name).string().size() == 200);
    CHECK(cleaned_name(long_name).string().ends_with("x.nii.gz"));
}

TEST_CASE("a batch is its only file, the folder that was dropped, or the folder of all") {
    const ScratchFolder scratch;
    Uploads uploads(scratch.path);
    upload(uploads, "head.nrrd", "b", "voxels");
    const UploadedBatch one = uploads.done("b");
    CHECK(one.name == "head.nrrd");
    CHECK(text_of(one.path) == "voxels");
    upload(uploads, "series/1.dcm", "b", "1");
    upload(uploads, "series/2.dcm", "b", "2");
    const UploadedBatch folder = uploads.done("b");
    CHECK(folder.name == "series");
    CHECK(folder.files == 2);
    CHECK(text_of(folder.path / "2.dcm") == "2");
    upload(uploads, "1.dcm", "c", "1");
    upload(uploads, "2.dcm", "c", "2");
    CHECK(text_of(uploads.done("c").path / "1.dcm") == "1");
}

TEST_CASE("a header that came with its data is what is opened") {
    const ScratchFolder scratch;
    Uploads uploads(scratch.path);
    upload(uploads, "knee/knee.mhd", "b", "header");
    upload(uploads, "knee/knee.raw", "b", "data");
    CHECK(uploads.done("b").path.filename() == "knee.mhd");
    upload(uploads, "a.mhd", "c", "header");
    upload(uploads, "b.mhd", "c", "header");
    CHECK(std::filesystem::is_directory(uploads.done("c").path));
}

TEST_CASE("an upload that breaks off leaves nothing behind and may come again") {
    const ScratchFolder scratch;
    Uploads uploads(scratch.path);
    uploads.begin("a.nrrd", "b", 10)->append("half");
    CHECK(status_of([&] { uploads.done("b"); }) == 400);
    upload(uploads, "a.nrrd", "b", "whole");
    CHECK(text_of(uploads.done("b").path) == "whole");
    const auto lying = uploads.begin("c.nrrd", "b", 3);
    CHECK(status_of([&] { lying->append("more"); }) == 400);
    const auto brief = uploads.begin("d.nrrd", "b", 3);
    CHECK(status_of([&] { brief->finish(); }) == 400);
}

TEST_CASE("uploads are refused when they would be too much, twice the same, or unnamed") {
    const ScratchFolder scratch;
    Uploads uploads(scratch.path);
    CHECK(status_of([&] { uploads.begin("a", "b", max_upload_bytes + 1); }) == 413);
    {
        const auto large = uploads.begin("a", "b", max_upload_bytes - 1);
        CHECK(status_of([&] { uploads.begin("c", "b", 2); }) == 413);
        CHECK(status_of([&] { uploads.begin("c", "b", UINT64_MAX); }) == 413);
        CHECK(status_of([&] { uploads.done("b"); }) == 400);
    }
    upload(uploads, "a", "b", "x");
    CHECK(status_of([&] { uploads.begin("a", "b", 1); }) == 409);
    const auto under_way = uploads.begin("c", "b", 1);
    CHECK(status_of([&] { uploads.done("b"); }) == 409);
    CHECK(status_of([&] { uploads.begin("..", "b", 1); }) == 400);
    for (const char* batch : {"", "..", "a/b", "a b", "\xff"}) {
        CHECK(status_of([&] { uploads.begin("a", batch, 1); }) == 400);
    }
}

TEST_CASE("a batch that was open is kept until its room is needed, the longest kept goes first") {
    const ScratchFolder scratch;
    Uploads uploads(scratch.path / "uploads");
    std::filesystem::create_directory(scratch.path / "uploads");
    upload(uploads, "series/1.dcm", "b", "1");
    upload(uploads, "series/2.dcm", "b", "2");
    const std::filesystem::path first = uploads.done("b").path;
    upload(uploads, "waits.nrrd", "b", "345");
    const std::filesystem::path waiting = uploads.done("b").path;
    upload(uploads, "next.nrrd", "c", "6");
    const std::filesystem::path next = uploads.done("c").path;
    CHECK(status_of([&] { uploads.begin("a", "d", max_upload_bytes - 5); }) == 413);

    uploads.opened(first);
    uploads.opened(first / "2.dcm");
    uploads.opened(next);
    CHECK(text_of(first / "1.dcm") == "1");
    CHECK(status_of([&] { uploads.begin("a", "d", max_upload_bytes - 3); }) == 413);
    CHECK_FALSE(std::filesystem::exists(first.parent_path()));
    CHECK(text_of(next) == "6");
    CHECK(status_of([&] { uploads.begin("a", "d", max_upload_bytes - 4); }) == 200);
    uploads.opened("");
    CHECK(text_of(next) == "6");
    CHECK(status_of([&] { uploads.begin("a", "d", max_upload_bytes - 3); }) == 200);
    CHECK_FALSE(std::filesystem::exists(next));
    CHECK(text_of(waiting) == "345");
}

TEST_CASE("several files come in one request, cut anywhere, and a broken one is refused") {
    const auto framed = [](const std::string& name, const std::string& text) {
        const auto little = [](std::uint64_t value, std::size_t bytes) {
            return std::string(reinterpret_cast<const char*>(&value), bytes);
        };
        return little(name.size(), 4) + little(text.size(), 8) + name + text;
    };
    const ScratchFolder scratch;
    Uploads uploads(scratch.path);
    const std::string body =
        framed("series/1.dcm", "first") + framed("series/2.dcm", "") + framed("series/3.dcm", "3");
    for (const std::size_t cut : {std::size_t{1}, std::size_t{7}, body.size()}) {
        UploadingFiles files(uploads, "b");
        for (std::size_t at = 0; at < body.size(); at += cut) {
            files.append(std::string_view(body).substr(at, cut));
        }
        files.finish();
        const UploadedBatch batch = uploads.done("b");
        CHECK(batch.files == 3);
        CHECK(text_of(batch.path / "1.dcm") == "first");
        CHECK(text_of(batch.path / "2.dcm") == "");
        CHECK(text_of(batch.path / "3.dcm") == "3");
    }
    const auto sends = [&](const std::string& text) {
        UploadingFiles files(uploads, "c");
        files.append(text);
        files.finish();
    };
    CHECK(status_of([&] { sends(body.substr(0, body.size() - 1)); }) == 400);
    CHECK(status_of([&] { sends("odd"); }) == 400);
    CHECK(status_of([&] { sends(framed("", "x")); }) == 400);
    CHECK(status_of([&] { sends(std::string(12, '\x7f')); }) == 400);
    CHECK(status_of([&] { sends(framed("..", "x")); }) == 400);
}

TEST_CASE("batches of a server before are not touched") {
    const ScratchFolder scratch;
    Uploads first(scratch.path), second(scratch.path);
    upload(first, "a", "b", "first");
    upload(second, "a", "b", "second");
    CHECK(text_of(first.done("b").path) == "first");
    CHECK(text_of(second.done("b").path) == "second");
}

}  // namespace pxpl5::host::serve

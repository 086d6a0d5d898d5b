// Files with flipped, cut and missing bytes: import takes them or throws ImportError, in little
// memory and time, and the ring takes what import takes. All of it happens in child processes,
// because decoders of others may end theirs.
#include <OpenImageIO/imageio.h>
#include <bzlib.h>
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <functional>
#include <numeric>
#include <random>

#include "host/io/formats/picture_stack.hpp"
#include "host/io/import.hpp"
#include "host/session/transfer/volume_transfer.hpp"
#include "ringbus/ranges.hpp"
#include "tests/file_bytes.hpp"
#include "tests/host/io/formats/vti_writer.hpp"
#include "tests/host/io/packed/packed.hpp"
#include "tests/host/io/volume_writers.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::io;
using namespace pxpl5::test;

#if defined(__SANITIZE_ADDRESS__)
// The sanitizer's own limit on one allocation; its memory is beyond setrlimit.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
    return "max_allocation_size_mb=1024:allocator_may_return_null=0:detect_leaks=0";
}
constexpr bool limits_data = false;
#else
constexpr bool limits_data = true;
#endif

namespace {

constexpr int mutations = 5000;
constexpr rlim_t most_bytes = rlim_t{1} << 30;
constexpr int most_cpu_s = 5;  ///< A longer import is a hang.

/// Counts of the imports' results, in memory that parent and children share.
struct Count {
    int next = 0;  ///< The import that goes on, or comes.
    int read = 0, refused = 0;
    int too_large = 0;  ///< More than most_bytes were wanted.
    int unnamed = 0;    ///< The complaint does not begin with the file.
    int unsent = 0;     ///< Imported, but the ring refuses its header: the machine would end.
};

struct Outcome {
    Count count;
    int aborted = 0, crashed = 0, hung = 0;
};

void limit_child() {
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(nowhere, STDERR_FILENO);  // GDCM prints its assertions.
    for (const int caught : {SIGABRT, SIGSEGV, SIGFPE, SIGILL, SIGTERM}) {
        std::signal(caught, SIG_DFL);  // Not doctest's: how the child ends is what is asked.
    }
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    if (limits_data) {
        const rlimit data{most_bytes, most_bytes};
        setrlimit(RLIMIT_DATA, &data);
    }
}

/// Imports what `write` writes, from number count.next on.
[[noreturn]] void import_all(Count& count, const std::function<ImportRequest(int)>& write) {
    limit_child();
    for (; count.next < mutations; ++count.next) {
        const ImportRequest request = write(count.next);
        const itimerval alarm{{0, 0}, {most_cpu_s, 0}};
        setitimer(ITIMER_VIRTUAL, &alarm, nullptr);
        try {
            const auto header = volume_header(import_volume(request), 1);
            const auto& message = *pxpl5::bus::schema::GetMessage(header.bytes().data());
            count.unsent += !pxpl5::bus::out_of_range(message, header.bytes().size()).empty();
            ++count.read;
        } catch (const ImportError& error) {
            const std::string text = error.what();
            ++count.refused;
            count.too_large += text.find("does not fit in the memory") != std::string::npos;
            count.unnamed += text.find(request.path.substr(0, request.path.rfind('/'))) != 0;
        }
    }
    _exit(0);
}

Outcome survive(const std::function<ImportRequest(int)>& write) {
    void* shared =
        mmap(nullptr, sizeof(Count), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    REQUIRE(shared != MAP_FAILED);
    auto& count = *new (shared) Count;
    Outcome outcome;
    while (count.next < mutations) {
        const pid_t child = fork();
        REQUIRE(child >= 0);
        if (child == 0) {
            import_all(count, write);
        }
        int status = 0;
        waitpid(child, &status, 0);
        if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
            break;
        }
        const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
        outcome.aborted += signal == SIGABRT;
        outcome.hung += signal == SIGVTALRM;
        outcome.crashed += signal != SIGABRT && signal != SIGVTALRM;
        ++count.next;
    }
    outcome.count = count;
    munmap(shared, sizeof(Count));
    return outcome;
}

/// The mutation `index` of `bytes`: cut, or up to eight bytes changed, half of them near the begin.
std::string mutated(std::string bytes, unsigned seed, int index) {
    std::mt19937 random(seed * 100'003U + static_cast<unsigned>(index));
    const auto below = [&](std::size_t end) { return std::size_t{random()} % end; };
    if (index % 5 == 0) {
        return bytes.substr(0, below(bytes.size()));
    }
    if (index % 5 == 1) {
        const std::size_t at = below(bytes.size());
        return bytes.erase(at, 1 + below(16));
    }
    for (std::size_t i = 0; i <= below(8); ++i) {
        constexpr std::size_t head_bytes = 600;
        const std::size_t at =
            below(i % 2 == 0 ? std::min(head_bytes, bytes.size()) : bytes.size());
        bytes[at] = static_cast<char>(random());
    }
    return bytes;
}

unsigned seed() {
    return pxpl5::test::seed_or(1993U);
}

Grid grid() {
    Grid small{{6, 5, 4}, glm::dmat4(1.0), ramp<std::int16_t>(120)};
    small.affine[3] = {10, -20, 30, 1};
    return small;
}

std::string bzipped(std::string bytes) {
    std::string out(bytes.size() + 1000, '\0');
    auto size = static_cast<unsigned>(out.size());
    BZ2_bzBuffToBuffCompress(out.data(), &size, bytes.data(), static_cast<unsigned>(bytes.size()),
                             9, 0, 0);
    return out.substr(0, size);
}

std::string nrrd_of(const std::string& encoding, const std::string& data) {
    return "NRRD0004\ntype: short\ndimension: 3\nspace: LPS\nsizes: 6 5 4\nendian: little\n"
           "space directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: " +
           encoding + "\n\n" + data;
}

/// Checks that hold for mutations of any format.
void check_outcome(const Outcome& outcome) {
    CHECK(outcome.count.too_large == 0);
    CHECK(outcome.count.unnamed == 0);
    CHECK(outcome.count.unsent == 0);
    CHECK(outcome.hung == 0);
    CHECK(outcome.count.refused > mutations / 10);  // They do break something.
}

/// Mutates `bytes` under `name`, and says what became of it.
Outcome mutate(const std::string& name, const std::string& bytes) {
    const TemporaryFolder folder;
    ImportRequest request;
    request.path = folder.write(name, bytes);
    if (name.ends_with(".hdr")) {
        folder.write(name.substr(0, name.size() - 4) + ".img", bytes_of(grid().values));
    }
    if (is_picture(name)) {
        request.spacing_mm = glm::dvec3(1, 1, 1);
    }
    request.frame = name.starts_with("frame.") ? 2 : 0;
    CAPTURE(name);
    CAPTURE(seed());
    const Outcome outcome = survive([&](int index) {
        folder.write(name, mutated(bytes, seed(), index));
        return request;
    });
    check_outcome(outcome);
    return outcome;
}

/// Our own decoders: nothing ends the process.
void check_survives(const std::string& name, const std::string& bytes) {
    const Outcome outcome = mutate(name, bytes);
    CAPTURE(name);
    CHECK(outcome.aborted == 0);
    CHECK(outcome.crashed == 0);
    CHECK(outcome.count.read + outcome.count.refused == mutations);
}

/// Decoders of others may end the process, but not often.
void check_mostly_survives(const std::string& name, const std::string& bytes) {
    const Outcome outcome = mutate(name, bytes);
    std::printf("%s: of %d mutations %d read, %d refused, %d aborted, %d crashed (seed %u)\n",
                name.c_str(), mutations, outcome.count.read, outcome.count.refused, outcome.aborted,
                outcome.crashed, seed());
    CHECK(outcome.aborted + outcome.crashed < mutations / 100);
    CHECK(outcome.count.read + outcome.count.refused + outcome.aborted + outcome.crashed ==
          mutations);
}

}  // namespace

TEST_SUITE("host/io/mutations") {
    TEST_CASE("2000 mutations of NIfTI and Analyze files") {
        const TemporaryFolder folder;
        check_survives("v.nii", nifti1_file(grid()));
        check_survives("w.nii", nifti2_file(grid()));
        check_survives("v.nii.gz", gzipped(folder, nifti1_file(grid())));
        NiftiHeader analyze = nifti1_header(grid());
        analyze.put<std::int32_t>(344, 0).put<float>(108, 0.0F);
        check_survives("v.hdr", analyze.bytes());
    }

    TEST_CASE("2000 mutations of NRRD files in five encodings") {
        const TemporaryFolder folder;
        const std::string values = bytes_of(grid().values);
        std::string hex, ascii;
        for (const char c : values) {
            hex += fmt::format("{:02x}", static_cast<unsigned char>(c));
        }
        for (const std::int16_t value : grid().values) {
            ascii += fmt::format("{} ", value);
        }
        check_survives("raw.nrrd", nrrd_of("raw", values));
        check_survives("gzip.nrrd", nrrd_of("gzip", gzipped(folder, values)));
        check_survives("bzip2.nrrd", nrrd_of("bzip2", bzipped(values)));
        check_survives("hex.nrrd", nrrd_of("hex", hex));
        check_survives("ascii.nrrd", nrrd_of("ascii", ascii));
        std::vector<double> wide(120);
        std::iota(wide.begin(), wide.end(), 0.5);
        std::string doubles = nrrd_of("raw", bytes_of(wide));
        check_survives("double.nrrd", doubles.replace(doubles.find("short"), 5, "double"));
    }

    TEST_CASE("2000 mutations of MetaImage and VTK files") {
        check_survives("v.mha", meta_image_file(grid()));
        check_survives("v.vtk", vtk_file(grid()));
        std::string text = vtk_file(grid());
        text.replace(text.find("BINARY"), 6, "ASCII");
        text.resize(text.find("default\n") + 8);
        for (const std::int16_t value : grid().values) {
            text += fmt::format("{}\n", value);
        }
        check_survives("a.vtk", text);
    }

    TEST_CASE("2000 mutations of VTK XML files, in each of four forms") {
        check_survives("ascii.vti", vti_file(grid(), {"ascii", ""}));
        check_survives("inline.vti", vti_file(grid(), {"binary", ""}));
        check_survives("raw.vti", vti_file(grid()));
        check_survives("base64.vti", vti_file(grid(), {"appended", "base64", true}));
    }

    TEST_CASE("2000 mutations of each file of OME-Zarr images") {
        for (const std::string name :
             {"blosc.zarr/.zattrs", "blosc.zarr/0/.zarray", "blosc.zarr/0/0/0/0",
              "zlib.zarr/0/0/0/0", "zstd.zarr/0/0.0.0", "series.zarr/0/.zarray"}) {
            const TemporaryFolder folder;
            std::filesystem::copy(PXPL5_ZARR_FOLDER, folder.file("images"),
                                  std::filesystem::copy_options::recursive);
            const std::string bytes = file_bytes(folder.file("images/" + name));
            ImportRequest request;
            request.path = folder.file("images/" + name.substr(0, name.find('/')));
            const Outcome outcome = survive([&](int index) {
                folder.write("images/" + name, mutated(bytes, seed(), index));
                return request;
            });
            CAPTURE(name);
            check_outcome(outcome);
            CHECK(outcome.aborted == 0);
            CHECK(outcome.crashed == 0);
        }
    }

    TEST_CASE("2000 mutations of MGH files") {
        const TemporaryFolder folder;
        check_survives("v.mgh", mgh_file(grid()));
        check_survives("v.mgz", gzipped(folder, mgh_file(grid())));
    }

    TEST_CASE("2000 mutations of time series, of which the second volume is read") {
        Grid series = grid();
        series.values = ramp<std::int16_t>(360);
        check_survives("frame.mgh", mgh_file(series, 3));
        NiftiHeader header = nifti1_header(series);
        header.put_dims({4, 6, 5, 4, 3, 1, 1, 1});
        check_survives("frame.nii", header.bytes() + bytes_of(series.values));
    }

    TEST_CASE("2000 mutations of DICOM files: GDCM's assertions hardly ever end the process") {
        check_mostly_survives("v.dcm", dicom_slice(grid(), 1).file());
        DicomSet frames = dicom_image(6, 5, bytes_of(grid().values));
        frames.text(0x28, 8, "IS", "4").text(0x18, 0x88, "DS", "1.5");
        DicomSet measures, shared;
        measures.text(0x28, 0x30, "DS", "1\\1");
        shared.sequence(0x28, 0x9110, {measures});
        frames.sequence(0x5200, 0x9229, {shared});
        check_mostly_survives("f.dcm", frames.file());
    }

    TEST_CASE("2000 mutations of each of three archives") {
        const TemporaryFolder folder;
        const NamedBytes series = {{"CT/IM1", dicom_slice(grid(), 0).file()},
                                   {"CT/IM2", dicom_slice(grid(), 1).file()}};
        const std::string tar = packed(series, ARCHIVE_FORMAT_TAR_USTAR);
        check_mostly_survives("v.zip", packed(series));
        check_mostly_survives("v.tar", tar);
        check_mostly_survives("v.tar.gz", gzipped(folder, tar));
    }

    TEST_CASE("2000 mutations of pictures") {
        const TemporaryFolder folder;
        for (const char* name : {"v.png", "v.tif", "v.jpg", "v.bmp"}) {
            const auto output = OIIO::ImageOutput::create(folder.file(name));
            const OIIO::ImageSpec spec(6, 20, 1, OIIO::TypeDesc::INT16);
            REQUIRE(output->open(folder.file(name), spec));
            REQUIRE(output->write_image(OIIO::TypeDesc::INT16, grid().values.data()));
            output->close();
            check_mostly_survives(name, file_bytes(folder.file(name)));
        }
    }
}

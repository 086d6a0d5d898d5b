// Writes the binary inputs of the corpus: write_seeds FOLDER. Run it after a change of a format.
#include <zlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/io/mesh/mesh_export.hpp"
#include "isa/assemble.hpp"
#include "tests/file_bytes.hpp"
#include "tests/host/io/dicom_files.hpp"
#include "tests/host/io/formats/vti_writer.hpp"
#include "tests/host/io/mesh_solids.hpp"
#include "tests/host/io/packed/packed.hpp"
#include "tests/host/io/volume_writers.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/ringbus/examples/examples.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

namespace fs = std::filesystem;

class Seeds {
  public:
    explicit Seeds(fs::path folder) : folder_(std::move(folder)) {}

    void write(const std::string& target, const std::string& name, const std::string& bytes) const {
        fs::create_directories(folder_ / target);
        std::ofstream(folder_ / target / name, std::ios::binary) << bytes;
    }

  private:
    fs::path folder_;
};

void write_messages(const Seeds& seeds) {
    constexpr std::size_t most_bytes = 4096;
    for (const bus::Payload& payload : one_of_each_kind()) {
        const auto bytes = payload.bytes();
        if (bytes.size() < most_bytes) {
            seeds.write(
                "message", bus::kind_name(payload.kind()),
                static_cast<char>(payload.kind()) + std::string(bytes.begin(), bytes.end()));
        }
    }
}

/// Edits of a message: each overwrites some bytes with a number that limits often have.
void write_message_edits(const Seeds& seeds) {
    constexpr int kinds = 39;
    for (int kind = 0; kind < kinds; ++kind) {
        const std::string edit("\0\40\0\0\0\5", 6);
        seeds.write("message", fmt::format("edits-{:02}", kind),
                    static_cast<char>(128 + kind) + edit + edit);
    }
}

void write_streams(const Seeds& seeds) {
    constexpr std::uint64_t programs = 6;
    for (std::uint64_t seed = 0; seed < programs; ++seed) {
        const std::string words = bytes_of(RandomPrograms(seed).program({25, seed % 2 == 0}));
        seeds.write("stream", fmt::format("program-{}", seed),
                    std::string("\2\40\30\0", 4) + words);
        seeds.write("assembly", fmt::format("words-{}", seed), "w" + words);
        RandomPrograms random(seed);
        std::string choices("\2\40\30\1", 4);
        for (int i = 0; i < 160; ++i) {
            choices += static_cast<char>(random.below(256));
        }
        seeds.write("stream", fmt::format("choices-{}", seed), choices);
    }
    const auto op = static_cast<char>(isa::op_count);
    seeds.write("stream", "triangles",
                std::string("\1\40\30\1", 4) + op + std::string(40, '\2') + op +
                    std::string(40, '\7') + op + std::string(40, '\x31'));
}

/// Numbers behind a question: its choice, the recording, and the pixel in the middle.
void write_questions(const Seeds& seeds) {
    constexpr char questions = 12;
    for (char question = 0; question < questions; ++question) {
        for (const char choice : {'\0', '\6'}) {
            const std::string head = {question, choice, 0, 64, 64};
            seeds.write("trace_questions", fmt::format("{:02}-{}", int{question}, int{choice}),
                        head);
        }
        seeds.write("trace_questions", fmt::format("{:02}-samples", int{question}),
                    {question, 0, 7, 64, 64});
    }
    seeds.write("trace_file", "written", "w");
    seeds.write("trace_file", "plain", "p");
    seeds.write("trace_file", "plain-cut", std::string("p\2\0\4\0\0\377\377", 8));
    seeds.write("trace_file", "plain-overwritten", std::string("p\0\0\2\0\0\34", 7));
}

Grid grid() {
    Grid small{{6, 5, 4}, glm::dmat4(1.0), ramp<std::int16_t>(120)};
    small.affine[3] = {10, -20, 30, 1};
    return small;
}

std::string nrrd(const std::string& encoding, const std::string& rest) {
    return "NRRD0004\ntype: short\ndimension: 3\nspace: LPS\nsizes: 6 5 4\nendian: little\n"
           "space directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: " +
           encoding + "\n" + rest;
}

void write_volumes(const Seeds& seeds) {
    const TemporaryFolder folder;
    const std::string values = bytes_of(grid().values), next = "\x1e";
    std::string hex, ascii;
    for (const std::int16_t value : grid().values) {
        ascii += fmt::format("{} ", value);
    }
    for (const char c : values) {
        hex += fmt::format("{:02x}", static_cast<unsigned char>(c));
    }
    constexpr char states_spacing = 16;
    // A letter, then a byte that asks for no processing.
    const auto add = [&](const char* name, char letter, const std::string& bytes,
                         char processing = 0) {
        seeds.write("volume", name, std::string{letter, processing} + bytes);
    };
    add("nifti1", 'n', nifti1_file(grid()));
    add("nifti2", 'n', nifti2_file(grid()));
    add("nifti-gz", 'z', gzipped(folder, nifti1_file(grid())));
    add("nifti-packed", 'Z', nifti1_file(grid()));
    NiftiHeader analyze = nifti1_header(grid());
    analyze.put<std::int32_t>(344, 0).put<float>(108, 0.0F);
    add("analyze", 'a', analyze.bytes().substr(0, 348) + values);
    add("nrrd", 'r', nrrd_file(grid()));
    add("nrrd-gzip", 'r', nrrd("gzip", "\n" + gzipped(folder, values)));
    add("nrrd-hex", 'r', nrrd("hex", "\n" + hex));
    add("nrrd-ascii", 'r', nrrd("ascii", "\n" + ascii));
    add("nhdr", 'R', nrrd("raw", "data file: v.raw\n\n" + next + values));
    add("nhdr-list", 'R', nrrd("raw", "data file: LIST\nv.raw\n" + next + values));
    add("mha", 'm', meta_image_file(grid()));
    std::string mhd = meta_image_file(grid());
    mhd.replace(mhd.find("LOCAL\n"), 6, "v.raw\n" + next);
    add("mhd", 'M', mhd);
    add("mgh", 'g', mgh_file(grid()));
    add("mgz", 'G', mgh_file(grid()));
    add("vtk", 'v', vtk_file(grid()));
    std::string text = vtk_file(grid());
    text.replace(text.find("BINARY"), 6, "ASCII");
    text.resize(text.find("default\n") + 8);
    add("vtk-ascii", 'v', text + ascii);
    add("vti-ascii", 'x', vti_file(grid(), {"ascii", ""}));
    add("vti-inline", 'x', vti_file(grid(), {"binary", ""}));
    add("vti-raw", 'x', vti_file(grid()));
    add("vti-zlib", 'x', vti_file(grid(), {"appended", "raw", true}));
    add("vti-base64", 'x', vti_file(grid(), {"appended", "base64", true}));
    add("raw", 'w', std::string("\6\5\4\3\0\0", 6) + values, states_spacing);
    add("by-content", '?', nrrd_file(grid()));
    seeds.write("volume", "nifti-processed",
                std::string("n\17\0\0\0\4\3\3\2\2\2\100", 12) + nifti1_file(grid()));
}

/// Shipped images of OME-Zarr, each with its first chunk, behind a byte that asks for no
/// processing.
void write_zarr(const Seeds& seeds) {
    const fs::path shipped = PXPL5_ZARR_FOLDER;
    const auto json = [&](const fs::path& file) {
        return nlohmann::json::parse(file_bytes(shipped / file)).dump();
    };
    for (const auto& [name, chunk] :
         std::initializer_list<std::pair<const char*, const char*>>{{"plain", "0/0/0/0"},
                                                                    {"zlib", "0/0/0/0"},
                                                                    {"zstd", "0/0.0.0"},
                                                                    {"blosc", "0/0/0/0"},
                                                                    {"series", "0/0/0/0/0/0"}}) {
        const fs::path image = std::string(name) + ".zarr";
        seeds.write("zarr", name,
                    std::string(1, '\0') + json(image / ".zattrs") + '\x1e' +
                        json(image / "0/.zarray") + '\x1e' + file_bytes(shipped / image / chunk));
    }
}

/// The elements behind the preamble, behind a byte that asks for no processing.
std::string elements(const DicomSet& set) {
    return set.file().substr(132);
}

void write_dicom(const Seeds& seeds) {
    const std::string next = "\xff\xff-next-file-\xff\xff", none(1, '\0');
    const Grid small{{3, 3, 3}, glm::dmat4(1.0), ramp<std::int16_t>(27)};
    seeds.write("dicom", "slice", none + elements(dicom_slice(small, 1)));
    seeds.write("dicom", "series",
                none + elements(dicom_slice(small, 0)) + next + elements(dicom_slice(small, 1)) +
                    next + elements(dicom_slice(small, 2)));
    DicomSet frames = dicom_image(3, 3, bytes_of(small.values));
    frames.text(0x28, 8, "IS", "3").text(0x18, 0x88, "DS", "1.5");
    DicomSet measures, shared;
    measures.text(0x28, 0x30, "DS", "1\\1");
    shared.sequence(0x28, 0x9110, {measures});
    frames.sequence(0x5200, 0x9229, {shared});
    seeds.write("dicom", "frames", none + elements(frames));
    seeds.write("dicom", "mosaic", none + elements(mosaic()));
}

/// A folder and four files: two of them are DICOM, and have one name.
void write_archives(const Seeds& seeds) {
    const Grid small{{3, 3, 3}, glm::dmat4(1.0), ramp<std::int16_t>(27)};
    const NamedBytes files = {{"CT/", ""},
                              {"CT/IM1", dicom_slice(small, 0).file()},
                              {"CT/IM1", dicom_slice(small, 1).file()},
                              {"CT/no", "1"},
                              {"../no", "2"}};
    const auto add = [&](const char* name, const std::string& letter, auto... how) {
        std::string bytes = packed(files, how...);
        if (letter != "a") {  // The target appends the end of a tar archive.
            bytes.resize((bytes.find_last_not_of('\0') / 512 + 1) * 512);
        }
        seeds.write("archive", name, letter + bytes);
    };
    add("zip", "a", ARCHIVE_FORMAT_ZIP);
    add("zip-stored", "a", ARCHIVE_FORMAT_ZIP, ARCHIVE_FILTER_NONE, "zip:compression=store");
    add("zip-64", "a", ARCHIVE_FORMAT_ZIP, ARCHIVE_FILTER_NONE, "zip:zip64");
    add("zip-password", "a", ARCHIVE_FORMAT_ZIP, ARCHIVE_FILTER_NONE, "zip:encryption=zipcrypt",
        "word");
    add("tar", "t", ARCHIVE_FORMAT_TAR_USTAR);
    add("tar-pax", "T", ARCHIVE_FORMAT_TAR_PAX_INTERCHANGE);
    add("tar-sparse", "t", ARCHIVE_FORMAT_TAR_PAX_INTERCHANGE, ARCHIVE_FILTER_NONE, nullptr,
        nullptr, 1, 300);
    add("tar-gnu", "T", ARCHIVE_FORMAT_TAR_GNUTAR);
    add("tar-gzip", "a", ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FILTER_GZIP);
    add("tar-bzip2", "a", ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FILTER_BZIP2);
    add("tar-xz", "a", ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FILTER_XZ);
    add("tar-zstd", "a", ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FILTER_ZSTD);
}

void write_meshes(const Seeds& seeds) {
    const TemporaryFolder folder;
    const Solid solid = tetrahedron();
    host::io::MeshExport mesh;
    mesh.surfaces = {solid.view()};
    for (const char* suffix : {"stl", "ply", "vtp", "obj"}) {
        const std::string path = folder.file(std::string("m.") + suffix);
        host::io::write_mesh(path, mesh);
        seeds.write("mesh", suffix, *suffix + file_bytes(path));
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("usage: write_seeds FOLDER\n", stderr);
        return 64;
    }
    const Seeds seeds(argv[1]);
    write_messages(seeds);
    write_message_edits(seeds);
    write_streams(seeds);
    write_questions(seeds);
    write_volumes(seeds);
    write_zarr(seeds);
    write_dicom(seeds);
    write_archives(seeds);
    write_meshes(seeds);
    return 0;
}

#include "tests/ringbus/examples/volume_examples.hpp"

#include "generated/vocabulary.hpp"
#include "tests/ringbus/examples/examples.hpp"

namespace pxpl5::test {

namespace schema = bus::schema;
using bus::pack;
using bus::Payload;

namespace {

schema::ExportMeshT example_mesh() {
    schema::ExportMeshT mesh;
    mesh.path = "skin.ply";
    auto surface = std::make_unique<schema::ExportSurfaceT>();
    surface->name = "skin";
    surface->color = std::make_unique<schema::Rgb>(1, 2, 3);
    surface->vertices.assign(3, schema::MeshVertex(1, 2, 3, 0, 0, 1));
    surface->indices = {0, 1, 2};
    mesh.surfaces.push_back(std::move(surface));
    mesh.axes = PatientAxes::RAS;
    return mesh;
}

}  // namespace

schema::VolumeHeaderT example_header() {
    schema::VolumeHeaderT header;
    header.volume = 9;
    header.name = "pelvis";
    header.nx = 4;
    header.ny = 5;
    header.nz = 6;
    header.type = Scalar::float32;
    header.voxel_to_patient = std::make_unique<schema::Matrix>(identity());
    header.minimum = -1000;
    header.maximum = 3000;
    header.slice_places = {0, 1, 2, 3, 5, 6};
    header.gap_slabs = {3};
    header.slabs_per_set = 2;
    header.gradient = GradientKernel::smooth;
    header.modality = "CT";
    header.series = "1.2.840.1";
    header.unit = "HU";
    header.windows.push_back(std::make_unique<schema::NamedWindowT>());
    header.windows[0]->name = "lung";
    header.windows[0]->width = 1500;
    header.windows[0]->level = -600;
    header.suv_per_value = 0.25;
    header.frame = 2;
    header.frames = 5;
    header.times_ms = {0, 30, 40, 90, 100};
    header.findings.push_back(std::make_unique<schema::FindingT>());
    header.findings[0]->kind = FindingKind::missing_slices;
    header.findings[0]->text = "one slice is missing";
    header.stored = std::make_unique<schema::StoredVolumeT>();
    header.stored->component = Component::float32;
    header.stored->files.push_back(std::make_unique<schema::SlicesFileT>());
    header.stored->files[0]->path = "/data/pelvis.raw";
    header.stored->files[0]->offset = 20;
    header.stored->files[0]->slices = 6;
    header.stored->files[0]->size_bytes = 500;  // 20 and 4 x 5 x 6 values of 4 bytes.
    header.reduction = 2;
    return header;
}

std::vector<Payload> volume_examples() {
    schema::ImportVolumeT import;
    import.path = "pelvis.nrrd";
    import.series = "2";
    import.spacing_mm = {1, 2, 3};
    import.raw = std::make_unique<schema::RawLayoutT>();
    import.raw->nx = import.raw->ny = import.raw->nz = 64;
    import.raw->type = "int16";
    import.crop_first = {0, 1, 2};
    import.crop_size = {10, 11, 12};
    import.resample_size = {20, 22, 24};
    import.smooth_mm = 0.5;
    import.gradient = GradientKernel::smooth;
    import.frame = 3;
    import.volumes = 2;
    import.orientation = "RAI";
    import.origin_mm = {-10, 20, 30.5};
    schema::SlicesT slices;
    slices.volume = 9;
    slices.first_slice = 4;
    slices.slice_count = 2;
    slices.values = {1, 2, 3, 4, 5, 6, 7, 8};
    schema::VolumeEndT end;
    end.volume = 9;
    schema::VolumeReadyT ready;
    ready.volume = 9;
    ready.slabs = 12;
    ready.memory_bytes = 1 << 20;
    ready.elapsed_us = 999;
    ready.slices = 15;
    ready.rows_in_runs = 40;
    ready.runs = 100;
    schema::ExportPictureT picture;
    picture.path = "skin.png";
    picture.width = 2;
    picture.height = 1;
    picture.rgba = {1, 2, 3, 4, 5, 6, 7, 8};
    picture.description = "skin";
    auto attribute = std::make_unique<schema::AttributeT>();
    attribute->name = "isovalue";
    attribute->value = "300";
    picture.attributes.push_back(std::move(attribute));
    auto mark = std::make_unique<schema::MarkT>();
    mark->kind = MarkKind::text;
    mark->points = {schema::PicturePoint(1, 0.5F)};
    mark->color = std::make_unique<schema::Rgba>(255, 255, 255, 128);
    mark->text = "L";
    picture.marks.push_back(std::move(mark));
    schema::IoDoneT done;
    done.error = "no such file";
    done.bad_data = true;
    schema::DropVolumeT drop;
    drop.volume = 9;
    schema::FetchVoxelsT fetch;
    fetch.box = std::make_unique<schema::VoxelBox>(1, 2, 3, 4, 1, 2);
    schema::VoxelValuesT found;
    found.slices = {3, 4};
    found.values = {1, 2, 3, 4, 5, 6, 7, 8};
    schema::ReadMeshT read;
    read.path = "skin.stl";
    schema::MeshContentT content;
    content.surfaces = example_mesh().surfaces;
    return {pack(example_header()), pack(found),   pack(fetch),
            pack(slices),           pack(content), pack(read),
            pack(import),           pack(ready),   pack(end),
            pack(example_mesh()),   pack(done),    pack(drop),
            pack(picture)};
}

}  // namespace pxpl5::test

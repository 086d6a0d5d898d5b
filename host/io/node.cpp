#include "host/io/node.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <memory>
#include <utility>

#include "host/io/import.hpp"
#include "host/io/picture.hpp"

namespace pxpl5::host::io {

namespace {

namespace schema = bus::schema;

bus::Payload failure(const std::string& reason, bool bad_data) {
    schema::IoDoneT done;
    done.ok = false;
    done.error = reason;
    done.bad_data = bad_data;
    return bus::pack(done);
}

schema::ScalarType wire_type(Scalar type) {
    return static_cast<schema::ScalarType>(type);
}
static_assert(static_cast<int>(Scalar::float32) == static_cast<int>(schema::ScalarType::float32));
static_assert(static_cast<int>(Scalar::uint16) == static_cast<int>(schema::ScalarType::uint16));

bus::Payload header_message(const Volume& volume, std::uint32_t id) {
    schema::VolumeHeaderT header;
    header.volume = id;
    header.name = volume.name;
    header.nx = static_cast<std::uint32_t>(volume.nx);
    header.ny = static_cast<std::uint32_t>(volume.ny);
    header.nz = static_cast<std::uint32_t>(volume.nz);
    header.type = wire_type(volume.type);
    // Both are column-major.
    const flatbuffers::span<const double, 16> columns(&volume.voxel_to_patient[0][0], 16);
    header.voxel_to_patient = std::make_unique<schema::Matrix>(columns);
    header.minimum = volume.minimum;
    header.maximum = volume.maximum;
    header.notes = volume.notes;
    return bus::pack(header);
}

std::size_t slice_bytes(const Volume& volume) {
    return static_cast<std::size_t>(volume.nx) * static_cast<std::size_t>(volume.ny) *
           size_bytes(volume.type);
}

/// As many whole slices from `first` on as fit in batch_bytes, at least one.
int batch_slices(const Volume& volume, int first) {
    const std::size_t fitting = std::max<std::size_t>(batch_bytes / slice_bytes(volume), 1);
    return std::min(static_cast<int>(std::min<std::size_t>(fitting, max_dim)), volume.nz - first);
}

bus::Payload slices_message(const Volume& volume, std::uint32_t id, int first, int count) {
    const std::size_t bytes = slice_bytes(volume) * static_cast<std::size_t>(count);
    const std::byte* from =
        volume.values.data() + slice_bytes(volume) * static_cast<std::size_t>(first);
    flatbuffers::FlatBufferBuilder builder(bytes + 1024);
    const auto values = builder.CreateVector(reinterpret_cast<const std::uint8_t*>(from), bytes);
    return bus::finish(builder, schema::CreateSlices(builder, id, static_cast<std::uint32_t>(first),
                                                     static_cast<std::uint32_t>(count), values));
}

void export_picture(const bus::Message& request, bus::Outbox& out) {
    const auto& wish = *request.as<schema::ExportPicture>();
    try {
        Picture picture;
        picture.width = static_cast<int>(std::min<std::uint32_t>(wish.width(), INT32_MAX));
        picture.height = static_cast<int>(std::min<std::uint32_t>(wish.height(), INT32_MAX));
        picture.rgba = {wish.rgba()->data(), wish.rgba()->size()};
        picture.description = wish.description() ? wish.description()->str() : "";
        write_picture(wish.path()->str(), picture);
        schema::IoDoneT done;
        done.ok = true;
        out.send(request.source(), bus::pack(done));
    } catch (const PictureError& error) {
        out.send(request.source(), failure(error.what(), false));
    }
}

}  // namespace

void IoNode::receive(const bus::Message& message, bus::Outbox&) {
    switch (message.kind()) {
        case bus::Body::Topology:
        case bus::Body::Go:
            return;
        case bus::Body::ImportVolume:
        case bus::Body::ExportPicture:
            break;
        default:
            throw bus::NodeFault(schema::FaultCode::bad_message,
                                 "the io process does not serve " + bus::kind_name(message.kind()));
    }
    if (requests_.size() == max_requests) {
        throw bus::NodeFault(schema::FaultCode::bad_input,
                             fmt::format("{} requests wait already", max_requests));
    }
    requests_.push_back(message);
}

bool IoNode::work(bus::Outbox& out) {
    if (sending_) {
        send_slices(out);
    } else if (!requests_.empty()) {
        const bus::Message request = std::move(requests_.front());
        requests_.pop_front();
        limit_next_request(limits_);
        if (request.kind() == bus::Body::ImportVolume) {
            begin_import(request, out);
        } else {
            export_picture(request, out);
        }
    }
    return sending_ || !requests_.empty();
}

void IoNode::begin_import(const bus::Message& request, bus::Outbox& out) {
    assert(!sending_);
    try {
        Volume volume = import_volume(request.as<schema::ImportVolume>()->path()->str());
        sending_ = Sending{request.source(), volumes_++, std::move(volume), 0};
        out.send(sending_->to, header_message(sending_->volume, sending_->id));
    } catch (const ImportError& error) {
        out.send(request.source(), failure(error.what(), true));
    }
}

void IoNode::send_slices(bus::Outbox& out) {
    const int count = batch_slices(sending_->volume, sending_->next_slice);
    out.send(sending_->to,
             slices_message(sending_->volume, sending_->id, sending_->next_slice, count));
    sending_->next_slice += count;
    if (sending_->next_slice == sending_->volume.nz) {
        schema::VolumeEndT end;
        end.volume = sending_->id;
        out.send(sending_->to, bus::pack(end));
        sending_.reset();
    }
}

}  // namespace pxpl5::host::io

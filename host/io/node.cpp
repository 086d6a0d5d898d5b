#include "host/io/node.hpp"

#include <fmt/format.h>

#include <cassert>
#include <utility>

#include "host/io/export_requests.hpp"
#include "host/io/import.hpp"
#include "host/volume_transfer.hpp"

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
            out.send(request.source(),
                     bus::pack(export_picture(*request.as<schema::ExportPicture>())));
        }
    }
    return sending_ || !requests_.empty();
}

void IoNode::begin_import(const bus::Message& request, bus::Outbox& out) {
    assert(!sending_);
    try {
        Volume volume = import_volume(request.as<schema::ImportVolume>()->path()->str());
        sending_ = Sending{request.source(), volumes_++, std::move(volume), 0};
        out.send(sending_->to, volume_header(sending_->volume, sending_->id));
    } catch (const ImportError& error) {
        out.send(request.source(), failure(error.what(), true));
    }
}

void IoNode::send_slices(bus::Outbox& out) {
    const int left = sending_->volume.nz - sending_->next_slice;
    const int count = std::min(left, slices_per_batch(sending_->volume));
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

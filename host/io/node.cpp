#include "host/io/node.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <filesystem>
#include <optional>
#include <utility>

#include "host/io/archive_requests.hpp"
#include "host/io/export_requests.hpp"
#include "host/io/import.hpp"
#include "host/io/request_needs.hpp"
#include "host/volume/reduced.hpp"
#include "host/volume/volume_messages.hpp"

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

template <typename T>
std::optional<std::array<std::uint32_t, 3>> three(const T* values) {
    if (values == nullptr) {
        return std::nullopt;
    }
    return std::array{values->Get(0), values->Get(1), values->Get(2)};
}

std::optional<glm::dvec3> vector(const flatbuffers::Vector<double>* values) {
    if (values == nullptr) {
        return std::nullopt;
    }
    return glm::dvec3(values->Get(0), values->Get(1), values->Get(2));
}

/// Lengths of vectors have been checked on receipt.
ImportRequest request_of(const schema::ImportVolume& wish) {
    ImportRequest request;
    request.path = wish.path()->str();
    request.series = wish.series() ? wish.series()->str() : "";
    request.spacing_mm = vector(wish.spacing_mm());
    request.orientation = wish.orientation() ? wish.orientation()->str() : "";
    request.origin_mm = vector(wish.origin_mm());
    if (const schema::RawLayout* raw = wish.raw()) {
        request.raw = RawLayout{{raw->nx(), raw->ny(), raw->nz()},
                                raw->type()->str(),
                                raw->big_endian(),
                                raw->offset()};
    }
    request.crop_first = three(wish.crop_first());
    request.crop_size = three(wish.crop_size());
    request.resample_size = three(wish.resample_size());
    request.resample_spacing_mm = vector(wish.resample_spacing_mm());
    request.smooth_mm = wish.smooth_mm();
    request.read = wish.read();
    request.host_bytes = wish.host_bytes();
    request.reduced_bytes = wish.reduced_bytes();
    request.frame = wish.frame();
    return request;
}

/// Pages of the memory from `begin` to `end`, which are not read again, go back to the system:
/// else a volume is here twice while its slices wait to be sent.
void give_back(std::vector<std::byte>& values, std::size_t begin, std::size_t end) {
    const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    const auto base = reinterpret_cast<std::uintptr_t>(values.data());
    const std::uintptr_t first = (base + begin + page - 1) / page * page;
    const std::uintptr_t last = (base + end) / page * page;
    if (first < last) {
        madvise(values.data() + (first - base), last - first, MADV_DONTNEED);
    }
}

void send_all(std::vector<bus::Payload> answer, bus::NodeId to, bus::Outbox& out) {
    for (bus::Payload& payload : answer) {
        out.send(to, std::move(payload));
    }
}

/// Each picture of an animation may take as long as a request: 360 of a megapixel take minutes.
/// A mesh file has 20 s and 1 s per MiB, so that a reader that loops ends before its user does.
Limits limits_for(const bus::Message& request, Limits limits) {
    constexpr std::uint64_t least_mesh_s = 20;
    if (request.kind() == bus::Body::ReadMesh && limits.cpu_s != 0) {
        std::error_code error;
        const auto size =
            std::filesystem::file_size(request.as<schema::ReadMesh>()->path()->str(), error);
        limits.cpu_s = std::min(limits.cpu_s, least_mesh_s + (error ? 0 : size >> 20));
    }
    if (request.kind() == bus::Body::ExportPicture) {
        limits.cpu_s *= request.as<schema::ExportPicture>()->count();
    }
    return limits;
}

}  // namespace

void IoNode::receive(const bus::Message& message, bus::Outbox&) {
    switch (message.kind()) {
        case bus::Body::Topology:
        case bus::Body::Go:
            return;
        case bus::Body::ImportVolume:
        case bus::Body::ExportPicture:
        case bus::Body::ExportMesh:
        case bus::Body::ReadMesh:
        case bus::Body::ReadArchive:
            break;
        default:
            throw bus::NodeFault(schema::FaultCode::bad_message,
                                 "the io process does not serve " + bus::kind_name(message.kind()));
    }
    if (requests_.size() == max_requests) {
        throw bus::NodeFault(schema::FaultCode::bad_input,
                             fmt::format("{} requests wait already", max_requests));
    }
    if (confines_ && has_request_) {
        throw bus::NodeFault(schema::FaultCode::bad_input,
                             "the sandbox of this process lets it serve its first request only");
    }
    has_request_ = true;
    requests_.push_back(message);
}

bus::Doing IoNode::doing() {
    if (import_ && import_->sending) {
        const Sending& sending = *import_->sending;
        return {bus::Body::Slices, sending.id, static_cast<std::uint32_t>(sending.next_slice),
                static_cast<std::uint32_t>(kept(sending.volume).nz)};
    }
    if (import_) {
        return {bus::Body::ImportVolume};
    }
    return {requests_.empty() ? bus::Body::NONE : requests_.front().kind()};
}

bool IoNode::work(bus::Outbox& out) {
    if (import_) {
        work_on_import(out);
    } else if (!requests_.empty()) {
        const bus::Message request = std::move(requests_.front());
        requests_.pop_front();
        limit_next_request(limits_for(request, limits_));
        if (confines_) {
            confine(needs_of(request, allowed_));
        }
        if (request.kind() == bus::Body::ImportVolume) {
            begin_import(request);
            work_on_import(out);
        } else if (request.kind() == bus::Body::ExportMesh) {
            send_all(export_mesh(*request.as<schema::ExportMesh>()), request.source(), out);
        } else if (request.kind() == bus::Body::ReadMesh) {
            send_all(read_mesh_file(*request.as<schema::ReadMesh>()), request.source(), out);
        } else if (request.kind() == bus::Body::ReadArchive) {
            send_all(read_archive_file(*request.as<schema::ReadArchive>()), request.source(), out);
        } else {
            out.send(request.source(),
                     bus::pack(export_picture(*request.as<schema::ExportPicture>())));
        }
    }
    return import_ || !requests_.empty();
}

void IoNode::begin_import(const bus::Message& request) {
    assert(!import_);
    const auto& wish = *request.as<schema::ImportVolume>();
    ImportRequest import = request_of(wish);
    import.allowed = allowed_;
    const std::uint32_t last = std::max(import.frame, 1U) + wish.volumes() - 1;
    import_ = Import{request.source(), Importer(std::move(import)), wish.frame(), last, {}};
}

void IoNode::work_on_import(bus::Outbox& out) {
    if (import_->sending) {
        send_slices(out);
        return;
    }
    try {
        begin_volume(out);
    } catch (const ImportError& error) {
        out.send(import_->to, failure(error.what(), true));
        import_.reset();
    }
}

void IoNode::begin_volume(bus::Outbox& out) {
    Import& import = *import_;
    const bool later_follow = std::max(import.frame, 1U) < import.last_frame;
    Volume volume = import.importer.read(import.frame, later_follow);
    import.last_frame = std::min(import.last_frame, static_cast<std::uint32_t>(volume.frames));
    import.sending = Sending{volumes_++, std::move(volume), 0};
    out.send(import.to, volume_header(import.sending->volume, import.sending->id));
}

void IoNode::send_slices(bus::Outbox& out) {
    Sending& sending = *import_->sending;
    const Volume& volume = kept(sending.volume);
    const int left = volume.nz - sending.next_slice;
    const int count = std::min(left, slices_per_batch(volume));
    out.send(import_->to, slices_message(volume, sending.id, sending.next_slice, count));
    const auto first = static_cast<std::size_t>(sending.next_slice);
    if (!sending.volume.reduced) {
        give_back(sending.volume.values, first * slice_bytes(volume),
                  (first + static_cast<std::size_t>(count)) * slice_bytes(volume));
    }
    sending.next_slice += count;
    if (sending.next_slice < volume.nz) {
        return;
    }
    schema::VolumeEndT end;
    end.volume = sending.id;
    out.send(import_->to, bus::pack(end));
    import_->frame = static_cast<std::uint32_t>(sending.volume.frame) + 1;
    import_->sending.reset();
    if (import_->frame > import_->last_frame) {
        import_.reset();
    }
}

}  // namespace pxpl5::host::io

#include "gp_firmware/node/job_queue.hpp"

#include <algorithm>
#include <limits>

namespace pxpl5::gp {

void JobQueue::add_extraction(ExtractJob extraction) {
    // The newest revision replaces older ones, begun or not. Jobs before the surface's removal
    // belong to an earlier surface of the same number.
    for (auto job = jobs_.end(); job != jobs_.begin();) {
        --job;
        if (const auto* removal = std::get_if<RemoveJob>(&*job);
            removal != nullptr && removal->surface == extraction.surface) {
            break;
        }
        if (const auto* older = std::get_if<ExtractJob>(&*job);
            older != nullptr && older->surface == extraction.surface) {
            job = jobs_.erase(job);
        }
    }
    const auto shows_it = [&](const Job& job) {
        const auto* draw = std::get_if<DrawJob>(&job);
        return draw != nullptr &&
               std::ranges::any_of(draw->request.surfaces, [&](const SurfaceWanted& wanted) {
                   return wanted.surface == extraction.surface &&
                          wanted.revision >= extraction.revision;
               });
    };
    jobs_.insert(std::ranges::find_if(jobs_, shows_it), std::move(extraction));
}

void JobQueue::add_removal(std::uint16_t surface) {
    announce(surface, std::numeric_limits<std::uint32_t>::max());
    add(RemoveJob{surface});
}

std::optional<Job> JobQueue::drop_voxels() {
    const auto found = std::ranges::find_if(
        jobs_, [](const Job& job) { return std::holds_alternative<VoxelsJob>(job); });
    if (found == jobs_.end()) {
        return std::nullopt;
    }
    std::optional<Job> dropped = std::move(*found);
    jobs_.erase(found);
    return dropped;
}

bool JobQueue::awaits_surface(const Job& job) const {
    const auto* draw = std::get_if<DrawJob>(&job);
    return draw != nullptr && std::ranges::any_of(draw->request.surfaces, [&](const auto& wanted) {
               const auto newest = announced_.find(wanted.surface);
               return newest != announced_.end() && newest->second < wanted.revision;
           });
}

Job* JobQueue::front() {
    if (!jobs_.empty()) {
        return awaits_surface(jobs_.front()) ? nullptr : &jobs_.front();
    }
    return measurement_ ? &*measurement_ : nullptr;
}

void JobQueue::pop() {
    if (jobs_.empty()) {
        measurement_.reset();
    } else {
        jobs_.pop_front();
    }
}

std::vector<Job> JobQueue::clear() {
    std::vector<Job> owed;
    for (Job& job : jobs_) {
        if (std::holds_alternative<DrawJob>(job) || std::holds_alternative<FetchJob>(job) ||
            std::holds_alternative<VoxelsJob>(job)) {
            owed.push_back(std::move(job));
        }
    }
    if (std::optional<Job> measurement = drop_measurement()) {
        owed.push_back(std::move(*measurement));
    }
    jobs_.clear();
    announced_.clear();
    return owed;
}

}  // namespace pxpl5::gp

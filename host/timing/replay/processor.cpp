#include "host/timing/replay/processor.hpp"

#include <algorithm>

namespace pxpl5::host::timing {

Ns Processor::message(Ns time) {
    busy_.add(events_.now(), time);
    messages_end_ = std::max(messages_end_, events_.now()) + time;
    job_end_ += time;  // Without a job it means nothing.
    return messages_end_;
}

void Processor::work(Ns time, Callback<> done) {
    busy_.add(events_.now(), time);
    jobs_.push_back({time, done});
    if (jobs_.size() == 1) {
        begin_next();
    }
}

void Processor::begin_next() {
    job_end_ = std::max(messages_end_, events_.now()) + jobs_.front().time;
    events_.at(job_end_, [this] { end(); });
}

void Processor::end() {
    if (job_end_ > events_.now()) {  // Messages came between.
        events_.at(job_end_, [this] { end(); });
        return;
    }
    Callback<> done = jobs_.front().done;
    jobs_.pop_front();
    if (!jobs_.empty()) {
        begin_next();
    }
    done();
}

}  // namespace pxpl5::host::timing

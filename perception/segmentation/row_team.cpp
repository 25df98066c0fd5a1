#include "perception/segmentation/row_team.hpp"

namespace ballservo {

RowTeam::RowTeam(int threads) {
  helpers_.reserve(static_cast<std::size_t>(threads > 1 ? threads - 1 : 0));
  for (int band = 1; band < threads; ++band) helpers_.emplace_back([this, band] { help(band); });
}

RowTeam::~RowTeam() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    closed_ = true;
  }
  begun_.notify_all();
  for (std::thread& helper : helpers_) helper.join();
}

void RowTeam::run(int rows, Call call, const void* work) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    rows_ = rows;
    call_ = call;
    work_ = work;
    busy_ = static_cast<int>(helpers_.size());
    ++round_;
  }
  begun_.notify_all();
  do_band(0);
  std::unique_lock<std::mutex> lock(mutex_);
  ended_.wait(lock, [this] { return busy_ == 0; });
}

void RowTeam::do_band(int band) const {
  const auto start = [this](long number) { return static_cast<int>(number * rows_ / threads()); };
  if (start(band) < start(band + 1)) call_(work_, start(band), start(band + 1));
}

void RowTeam::help(int band) {
  std::unique_lock<std::mutex> lock(mutex_);
  for (long done = 0;;) {
    begun_.wait(lock, [&] { return closed_ || round_ != done; });
    if (closed_) return;
    done = round_;
    lock.unlock();
    do_band(band);
    lock.lock();
    if (--busy_ == 0) ended_.notify_one();
  }
}

}  // namespace ballservo

// SPDX-License-Identifier: Apache-2.0
// Tells the kernel that the CPU reads a DMA buffer, so that its caches and the device agree.
#pragma once

#include <linux/dma-buf.h>
#include <sys/ioctl.h>

#include <cerrno>

namespace srd {

// begin before the first read, end after the last. Memory that is no DMA buffer needs neither: refusals are no faults.
inline void sync_dma_buf(int fd, unsigned long long flags) noexcept {
  dma_buf_sync sync{flags};
  while (::ioctl(fd, DMA_BUF_IOCTL_SYNC, &sync) != 0 && (errno == EINTR || errno == EAGAIN)) {}
}
inline void begin_cpu_read(int fd) noexcept { sync_dma_buf(fd, DMA_BUF_SYNC_START | DMA_BUF_SYNC_READ); }
inline void end_cpu_read(int fd) noexcept { sync_dma_buf(fd, DMA_BUF_SYNC_END | DMA_BUF_SYNC_READ); }

// For a read that ends where it began.
class CpuRead {
 public:
  explicit CpuRead(int fd) noexcept : fd_(fd) { begin_cpu_read(fd_); }
  ~CpuRead() { end_cpu_read(fd_); }
  CpuRead(const CpuRead&) = delete;
  CpuRead& operator=(const CpuRead&) = delete;

 private:
  int fd_;
};

}  // namespace srd

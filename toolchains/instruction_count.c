// SPDX-License-Identifier: Apache-2.0
/* A plugin for qemu 7.2 or later that counts the instructions a program executes. To the file that INSTRUCTION_COUNT names
   it writes the number, and then a line "address number" for every piece of code in hexadecimal and decimal. Declarations from qemu's public plugin interface, version 1: Debian ships no header. */
#include <inttypes.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_info;
enum { kInlineAddU64 = 0 };
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t, void (*)(qemu_plugin_id_t, struct qemu_plugin_tb*));
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t, void (*)(qemu_plugin_id_t, void*), void*);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb*);
uint64_t qemu_plugin_tb_vaddr(const struct qemu_plugin_tb*);
void qemu_plugin_register_vcpu_tb_exec_inline(struct qemu_plugin_tb*, int operation, void* counter, uint64_t addend);

#define EXPORTED __attribute__((visibility("default")))
EXPORTED int qemu_plugin_version = 1;

/* One piece of code without a jump inside, as often as it was translated. One thread. */
struct piece {
  struct piece* next;
  uint64_t address, executed;
};
static struct piece* pieces;

static void translated(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
  (void)id;
  struct piece* piece = calloc(1, sizeof *piece);
  if (!piece) abort();
  piece->address = qemu_plugin_tb_vaddr(block);
  piece->next = pieces;
  pieces = piece;
  qemu_plugin_register_vcpu_tb_exec_inline(block, kInlineAddU64, &piece->executed, qemu_plugin_tb_n_insns(block));
}

static void finished(qemu_plugin_id_t id, void* nothing) {
  (void)id;
  (void)nothing;
  const char* name = getenv("INSTRUCTION_COUNT");
  FILE* out = name ? fopen(name, "w") : stderr;
  if (!out) return;
  uint64_t executed = 0;
  for (const struct piece* piece = pieces; piece; piece = piece->next) executed += piece->executed;
  fprintf(out, "%" PRIu64 "\n", executed);
  for (const struct piece* piece = pieces; piece; piece = piece->next)
    if (piece->executed) fprintf(out, "%" PRIx64 " %" PRIu64 "\n", piece->address, piece->executed);
  fflush(out);
}

EXPORTED int qemu_plugin_install(qemu_plugin_id_t id, const struct qemu_info* info, int argc, char** argv) {
  (void)info;
  (void)argc;
  (void)argv;
  qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
  qemu_plugin_register_atexit_cb(id, finished, NULL);
  return 0;
}

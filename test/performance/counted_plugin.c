/* For qemu-user: writes the number of instructions of each call of the function `counted`, see counted.h. */
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

/* Declarations of qemu-plugin.h, version 1, which Debian does not pack. */
struct qemu_plugin_tb;
struct qemu_plugin_insn;
typedef void (*translated)(uint64_t, struct qemu_plugin_tb*);
typedef void (*executed)(unsigned, void*);
void qemu_plugin_register_vcpu_tb_trans_cb(uint64_t, translated);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb*);
struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb*, size_t);
const char* qemu_plugin_insn_symbol(const struct qemu_plugin_insn*);
char* qemu_plugin_insn_disas(const struct qemu_plugin_insn*);
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn*, executed, int, void*);
void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn*, int, void*, uint64_t);
int qemu_plugin_version = 1;

static uint64_t count, start;
static bool runs;

static void step(unsigned cpu, void* isReturn) {
  (void)cpu;
  if (isReturn) {
    fprintf(stderr, "%" PRIu64 "\n", count - start);
    runs = false;
  } else if (!runs) {
    start = count;
    runs = true;
  }
}

static void translate(uint64_t id, struct qemu_plugin_tb* block) {
  (void)id;
  for (size_t i = 0; i < qemu_plugin_tb_n_insns(block); ++i) {
    struct qemu_plugin_insn* instruction = qemu_plugin_tb_get_insn(block, i);
    qemu_plugin_register_vcpu_insn_exec_inline(instruction, 0, &count, 1);
    const char* symbol = qemu_plugin_insn_symbol(instruction);
    if (!symbol || strcmp(symbol, "counted") != 0) continue;
    const bool isReturn = strncmp(qemu_plugin_insn_disas(instruction), "ret", 3) == 0;
    qemu_plugin_register_vcpu_insn_exec_cb(instruction, step, 0, isReturn ? &count : NULL);
  }
}

int qemu_plugin_install(uint64_t id, const void* info, int argc, char** argv) {
  (void)info, (void)argc, (void)argv;
  qemu_plugin_register_vcpu_tb_trans_cb(id, translate);
  return 0;
}

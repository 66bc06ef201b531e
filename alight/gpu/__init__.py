"""GPUs of NVIDIA by their driver alone: memory, code and launches."""

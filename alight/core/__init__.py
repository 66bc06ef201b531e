"""What every layer above builds on: value types, random numbers, warps, errors."""

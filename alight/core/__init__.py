"""What every layer above stands on: value types, random numbers, warps, errors."""

"""Fields of a scenario: sections of quantities with unit, meaning and bounds, validated."""

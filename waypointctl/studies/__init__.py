"""Studies: many flights in parallel; rehearsals, and the cost of delay by autonomy."""

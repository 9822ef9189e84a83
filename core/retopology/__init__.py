"""From umbilics to a plan for a quad mesh."""

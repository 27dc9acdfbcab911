"""An independent look at accepted states: plain arrays, none of the code that found them."""
